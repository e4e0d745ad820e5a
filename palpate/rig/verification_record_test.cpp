#include "palpate/rig/verification_record.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "palpate/rig/rig.h"

namespace palpate::rig {
namespace {

std::string complaint_of_verification(const std::string& lines) {
  const auto rig = parse_rig("rig_version = 1\n[[verification]]\n" + lines, "rig.toml");
  return rig ? "" : rig.error().message;
}

TEST(VerificationRecords, ReadBackAndOnlyTheNewestAreKept) {
  Rig rig;
  for (int day = 1; day <= 40; ++day)
    rig.verifications.push_back({fmt::format("2026-01-01T00:00:{:02d}Z", day),
                                 day % 2 == 0 ? "quick" : "full",
                                 day < 40,
                                 {},
                                 {{"arm_mm", 0.11, 0.08, 0.16, 0.2, 0.31, 0.4}}});
  rig.verifications.back().changed = {"arm base", "lens"};
  const auto again = parse_rig(rig_text(rig), "r.toml");
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_EQ(again->verifications.size(), kVerificationsKept);
  EXPECT_EQ(again->verifications.front().date, "2026-01-01T00:00:11Z");
  const VerificationRecord& last = again->verifications.back();
  EXPECT_EQ(last.form, "quick");
  EXPECT_FALSE(last.holds);
  EXPECT_EQ(last.changed, (std::vector<std::string>{"arm base", "lens"}));
  ASSERT_EQ(last.figures.size(), 1u);
  EXPECT_EQ(last.figures[0].name, "arm_mm");
  EXPECT_EQ(last.figures[0].promised, 0.2);
  EXPECT_EQ(last.figures[0].seen_most, 0.4);
}

TEST(VerificationRecords, MistakesAreNamed) {
  const std::string date = "date = \"2026-01-01T00:00:01Z\"\n", form = "form = \"full\"\n",
                    holds = "holds = true\n";
  EXPECT_EQ(complaint_of_verification(date + form + holds), "");
  EXPECT_NE(complaint_of_verification("date = \"today\"\n" + form + holds).find("today"), std::string::npos);
  EXPECT_NE(complaint_of_verification(date + "form = \"long\"\n" + holds).find("form"), std::string::npos);
  EXPECT_NE(complaint_of_verification(date + form).find("holds"), std::string::npos);
  EXPECT_NE(complaint_of_verification(date + form + holds + "arm_mm = [1, 2]\n").find("arm_mm"),
            std::string::npos);
}

}  // namespace
}  // namespace palpate::rig
