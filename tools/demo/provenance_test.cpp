#include "tools/demo/provenance.h"

#include <gtest/gtest.h>

namespace palpate::tools::demo {
namespace {

TEST(Provenance, TellsTheProgramTheMachineAndTheRightsOfTheRun) {
  const Provenance provenance({"0.1.0", "", "Clang 14.0.6", "Release"});
  const Json with = provenance.told({{"haptic", {{"scheduling", "SCHED_FIFO priority 80"}}}}),
             without = provenance.told(nullptr);
  EXPECT_EQ(with["version"], "0.1.0");
  EXPECT_EQ(with["commit"], nullptr) << "what is not known is not made up";
  EXPECT_EQ(with["compiler"], "Clang 14.0.6");
  EXPECT_EQ(with["scheduling"], "SCHED_FIFO priority 80");
  EXPECT_EQ(without["scheduling"], nullptr);
  EXPECT_EQ(with["date"].get<std::string>().size(), 20u);
  EXPECT_EQ(with["date"], without["date"]) << "when it began";
  EXPECT_GE(with["cores"], 1);
  for (const char* key : {"kernel", "load_before", "load_after"}) EXPECT_FALSE(with[key].is_null()) << key;
}

}  // namespace
}  // namespace palpate::tools::demo
