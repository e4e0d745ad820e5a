#include "tools/console/event_log.h"

#include <gtest/gtest.h>

namespace palpate::tools::console {
namespace {

using device::ForceFault;
using device::ForceState;

struct EventLogRig : ::testing::Test {
  EventLogRig() {
    view.server_answers = true;
    view.status.emplace();
    view.status->loops.resize(1);
    view.status->loops[0].forces = device::ForceCondition{ForceState::running, ForceFault::none};
    view.status->loops[0].trips = 7;  // before anybody looked
    view.status->clients.resize(1);
    view.status->clients[0].name = "screen";
    look();
  }
  void look() {
    view.status->uptime_s += 0.2;
    log.look(view);
  }
  std::vector<std::string> news() {
    std::vector<std::string> words;
    for (const auto& event : log.events())
      if (event.number > told) words.push_back(event.words), told = event.number;
    return words;
  }
  using Words = std::vector<std::string>;
  SystemView view;
  EventLog log;
  std::uint64_t told = 0;
};

TEST_F(EventLogRig, TellsNothingOfWhatWasBefore) {
  for (int i = 0; i < 5; ++i) look();
  EXPECT_EQ(news(), Words{});
}

TEST(EventLog, AServerThatWasNeverThereHasNotGone) {
  EventLog log;
  log.look({});
  EXPECT_TRUE(log.events().empty());
  log.look({true, {}, {}});
  EXPECT_TRUE(log.events().empty());
  log.look({});
  EXPECT_EQ(log.events().size(), 1u);
}

TEST_F(EventLogRig, TellsWhyForcesWentAndThatTheyCame) {
  auto& loop = view.status->loops[0];
  loop.forces = device::ForceCondition{ForceState::safe, ForceFault::overspeed}, loop.trips = 8;
  look(), look();
  EXPECT_EQ(news(), Words{"forces off: safe: overspeed"});
  EXPECT_EQ(log.events().back().level, Level::fault);
  loop.forces = device::ForceCondition{ForceState::running, ForceFault::none};
  look(), look();
  EXPECT_EQ(news(), Words{"forces are back"});
}

TEST_F(EventLogRig, CountsOutagesBetweenTwoLooks) {
  view.status->loops[0].trips = 9;
  look(), look();
  EXPECT_EQ(news(), Words{"2 outages of the forces, over by now"});
}

TEST_F(EventLogRig, TellsAConditionOnceAndItsEnd) {
  auto& conditions = view.status->clients[0].figures.conditions;
  conditions = {{device::HealthCode::tracker_silent, 0.5, "tracker: no samples for 0.5 s"}};
  look();
  conditions[0].age_s = 0.7;
  look();
  EXPECT_EQ(news(), Words{"screen: tracker: no samples for 0.5 s"});
  conditions.clear();
  look(), look();
  EXPECT_EQ(news(), Words{"screen: " + std::string(device::end_of(device::HealthCode::tracker_silent))});
}

TEST_F(EventLogRig, TellsThatTheServerWentAndThatAnotherCame) {
  for (int i = 0; i < 3; ++i) look();
  view.server_answers = false;
  look(), look();
  EXPECT_EQ(news(), Words{"the physics server no longer answers"});
  view.server_answers = true;
  view.status->uptime_s = 0.0;
  view.status->loops[0].trips = 0;
  look(), look();
  EXPECT_EQ(news(), (Words{"the physics server answers again",
                           "another physics server has taken the place of the one before"}));
}

TEST_F(EventLogRig, KeepsTheNewest) {
  auto& conditions = view.status->clients[0].figures.conditions;
  for (std::size_t i = 0; i < EventLog::kMost; ++i) {
    conditions = {{device::HealthCode::tracker_silent, 0.5, "gone"}};
    look();
    conditions.clear();
    look();
  }
  EXPECT_EQ(log.events().size(), EventLog::kMost);
  EXPECT_EQ(log.events().back().number, 2 * EventLog::kMost);
}

}  // namespace
}  // namespace palpate::tools::console
