// Settings of an application that no file of ours knows: what its schema says is all there is to go by.
#include "palpate/scene/setting_schema.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "palpate/core/random.h"

namespace palpate::scene {
namespace {

SettingSchema drill() {
  return {.fields = {{.section = "drill",
                      .key = "speed_rpm",
                      .initial = std::vector<double>{600.0},
                      .unit = 0.1047,
                      .range = {1.0, 5000.0}},
                     {.section = "drill",
                      .key = "offset_mm",
                      .kind = SettingKind::numbers,
                      .initial = std::vector<double>{1.0, 2.0, 3.0},
                      .unit = 1e-3},
                     {.section = "bone",
                      .key = "kind",
                      .kind = SettingKind::choice,
                      .initial = "femur",
                      .choices = {"femur", "skull"}},
                     {.section = "bone", .key = "scan", .kind = SettingKind::file, .initial = ""},
                     {.section = "bone",
                      .key = "depth_mm",
                      .kind = SettingKind::numbers,
                      .initial = std::vector<double>{0.0, 5.0},
                      .unit = 1e-3}},
          .relations =
              [](const SettingValues& values) {
                const auto depth = values.range("bone.depth_mm");
                std::vector<SettingComplaint> complaints;
                if (depth[0] > depth[1])
                  complaints.push_back({"bone", "depth_mm", "[low, high] is expected"});
                return complaints;
              },
          .version = 3};
}

TEST(SettingSchema, ValuesAreTheInitialOnesUntilSetAndAreReadInSi) {
  SettingValues values(drill());
  EXPECT_EQ(values.number("drill.speed_rpm"), 600.0 * 0.1047);
  EXPECT_EQ(values.vector("drill.offset_mm"), Vector3(1.0, 2.0, 3.0) * 1e-3);
  EXPECT_EQ(values.text("bone.kind"), "femur");
  values.set("drill.speed_rpm", 90.0);
  values.set("bone.depth_mm", std::vector<double>{1.0, 4.0});
  values.set("bone.kind", "skull");
  EXPECT_EQ(values.number("drill.speed_rpm"), 90.0 * 0.1047);
  EXPECT_EQ(values.range("bone.depth_mm"), (std::array{1.0 * 1e-3, 4.0 * 1e-3}));
  EXPECT_EQ(values.text("bone.kind"), "skull");
}

TEST(SettingSchema, WrongUseOfValuesThrows) {
  SettingValues values(drill());
  EXPECT_THROW(values.number("drill.size_mm"), std::out_of_range);
  EXPECT_THROW(values.number("bone.kind"), std::invalid_argument);
  EXPECT_THROW(values.text("drill.speed_rpm"), std::invalid_argument);
  EXPECT_THROW(values.set("drill.speed_rpm", "fast"), std::invalid_argument);
  EXPECT_THROW(values.set("drill.offset_mm", std::vector<double>{1.0}), std::invalid_argument);
  EXPECT_THROW(values.add(drill()), std::invalid_argument) << "a second owner of the same settings";
}

TEST(SettingSchema, AnothersValuesAreTakenWhereBothHaveTheField) {
  SettingSchema other = drill();
  other.fields.resize(1);
  SettingValues from(other);
  from.set("drill.speed_rpm", 7.0);
  SettingValues values(drill());
  values.take(from);
  EXPECT_EQ(values.number("drill.speed_rpm"), 7.0 * 0.1047);
  EXPECT_EQ(values.text("bone.kind"), "femur");
}

TEST(SettingSchema, EveryNumberComesBackFromAPayloadToTheBit) {
  Random random(1, "test/settings");
  SettingSchema schema = drill();
  for (auto& field : schema.fields) field.range = kAnyNumber;
  schema.relations = nullptr;
  for (int i = 0; i < 2000; ++i) {
    SettingValues values(schema);
    const double x = std::ldexp(random.normal(), static_cast<int>(random.below(2000)) - 1000);
    values.set("drill.speed_rpm", x);
    values.set("drill.offset_mm", std::vector<double>{random.uniform(), -x, std::nextafter(x, 1e308)});
    values.set("bone.scan", "a \"name\" with\\ signs and \n lines");
    const auto back = from_payload(schema, to_payload(schema, values));
    ASSERT_TRUE(back) << back.error().message;
    for (std::size_t k = 0; k < values.all().size(); ++k)
      EXPECT_EQ(back->all()[k].value, values.all()[k].value) << values.all()[k].field.name();
  }
}

TEST(SettingSchema, NoPayloadIsTheInitialValues) {
  const auto values = from_payload(drill(), Payload{});
  ASSERT_TRUE(values);
  EXPECT_EQ(values->text("bone.kind"), "femur");
}

std::string refusal_of(const Payload& payload) {
  const auto values = from_payload(drill(), payload);
  return values ? "taken" : values.error().message;
}

TEST(SettingSchema, APayloadThatIsNotAsTheSchemaHasItIsRefusedInWords) {
  const Payload good = to_payload(drill(), SettingValues(drill()));
  EXPECT_EQ(refusal_of(good), "taken");
  const auto spoiled = [&](const std::string& was, const std::string& is) {
    Payload payload = good;
    const auto at = payload.bytes.find(was);
    EXPECT_NE(at, std::string::npos) << was << " in " << payload.bytes;
    payload.bytes.replace(at, was.size(), is);
    return refusal_of(payload);
  };
  EXPECT_EQ(spoiled("600.0", "600"), "taken") << "an integer is a number";
  EXPECT_NE(spoiled("600.0", "9000.0").find("drill.speed_rpm: is 9000; 1 to 5000 is expected"),
            std::string::npos);
  EXPECT_NE(spoiled("600.0", "1e999").find("JSON is expected"), std::string::npos);
  EXPECT_NE(spoiled("600.0", "\"fast\"").find("drill.speed_rpm: is of another kind"), std::string::npos);
  EXPECT_NE(spoiled("[1.0,2.0,3.0]", "[1.0,2.0]").find("drill.offset_mm: is of another kind"),
            std::string::npos);
  EXPECT_NE(spoiled("[1.0,2.0,3.0]", "[1.0,null,3.0]").find("drill.offset_mm"), std::string::npos);
  EXPECT_NE(spoiled("femur", "liver").find("bone.kind: is liver; one of femur, skull is expected"),
            std::string::npos);
  EXPECT_NE(spoiled("[0.0,5.0]", "[6.0,5.0]").find("bone.depth_mm: [low, high] is expected"),
            std::string::npos);
  EXPECT_NE(spoiled("\"speed_rpm\":600.0,", "").find("drill.speed_rpm: is not among"), std::string::npos);
  EXPECT_NE(spoiled("\"kind\":", "\"more\":1,\"kind\":").find("6 values, 5 are expected"), std::string::npos);
  EXPECT_NE(refusal_of({3, ""}).find("JSON is expected"), std::string::npos);
  EXPECT_NE(refusal_of({3, "[]"}).find("JSON is expected"), std::string::npos);
  EXPECT_NE(refusal_of({2, good.bytes}).find("of version 2, this side knows 3"), std::string::npos);
  EXPECT_NE(refusal_of({3, std::string(kMaxPayloadBytes + 1, ' ')}).find("at most 32768"), std::string::npos);
}

TEST(SettingSchema, CheckNamesTheFirstValueThatCannotBe) {
  SettingValues values(drill());
  EXPECT_TRUE(check(drill(), values));
  values.set("drill.speed_rpm", std::numeric_limits<double>::quiet_NaN());
  const auto wrong = check(drill(), values);
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().kind, Error::Kind::wrong_use);
  EXPECT_NE(wrong.error().message.find("drill.speed_rpm: is nan"), std::string::npos)
      << wrong.error().message;
}

}  // namespace
}  // namespace palpate::scene
