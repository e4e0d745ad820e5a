// The person who plays behind the doors: sees what the physics server shows, as late as a picture shows it, and leads the
// laboratory's hand.
//
//   palpate_scripted_player LABORATORY ENDPOINT RIG SEED
//
// A picture's worth of states, 30 a second, each 60 ms old: what camera, transfer and drawing take. The application's own
// scripted player decides (palpate/scene/player.h), with the hand of the reference world. Runs until it is stopped or one
// of the two is gone. Never installed.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "applications/pingpong/specification.h"
#include "drivers/laboratory/channel.h"
#include "palpate/core/stop_signal.h"
#include "palpate/desktop/scripted_user.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application_registry.h"
#include "palpate/sim/config/world_file.h"
#include "palpate/transport/zmq_engine.h"

namespace palpate::doors {
namespace {

constexpr Duration kPicture = std::chrono::microseconds(33'333), kOld = std::chrono::milliseconds(60);
constexpr Duration kTick = std::chrono::milliseconds(1), kPatience = std::chrono::seconds(20);

// One machine has one clock, that of both servers.
Instant<PhysicsClock> of_physics(Instant<GraphicsClock> t) { return {t.since_epoch}; }

class Person {
 public:
  Person(transport::StateLink& link, drivers::laboratory::LabHand& hand, scene::Player& player)
      : link_(link), hand_(hand), player_(player) {}

  void tick(Instant<GraphicsClock> now) {
    link_.poll();
    for (const auto& arrived : link_.arrived())
      if (arrived.newest) player_.show(arrived.reply.answer.state, of_physics(now));
    if (now >= next_) {
      link_.request(++pictures_, of_physics(now - kOld));
      next_ = now + kPicture;
    }
    if (link_.newest()) hand_.move_to(player_.act(of_physics(now)));
  }

 private:
  transport::StateLink& link_;
  drivers::laboratory::LabHand& hand_;
  scene::Player& player_;
  std::uint64_t pictures_ = 0;
  Instant<GraphicsClock> next_;
};

Expected<void> play(const std::vector<std::string>& words) {
  if (words.size() != 4) return wrong_use("LABORATORY ENDPOINT RIG SEED are expected");
  auto laboratory = drivers::laboratory::LabClient::open(words[0]);
  if (!laboratory) return tl::unexpected(laboratory.error());
  auto hand = drivers::laboratory::LabHand::open(*laboratory);
  if (!hand) return tl::unexpected(hand.error());
  auto rig = rig::read_rig(words[2]);
  if (!rig) return tl::unexpected(rig.error());
  const auto endpoint = transport::parse_endpoint(words[1], transport::EndpointUse::connect);
  if (!endpoint) return tl::unexpected(endpoint.error());
  MonotonicClock<GraphicsClock> clock;
  auto link = transport::connect_states(*endpoint, clock, "player");
  if (!link) return tl::unexpected(link.error());
  for (const auto until = clock.now() + kPatience; !(*link)->description(); (*link)->poll()) {
    if (clock.now() > until) return refused("no physics server answers at {}", words[1]);
    clock.sleep_until(clock.now() + kTick);
  }
  auto settings = desktop::own_hand(sim::config::reference_world());
  settings.reaction_s = scene::PlayerSettings{}.reaction_s;
  settings.seed = std::strtoull(words[3].c_str(), nullptr, 10);
  const scene::ApplicationRegistry applications{applications::pingpong::specification()};
  auto player = applications.make_player(
      *(*link)->description(), desktop::players_reach(*rig, sim::config::reference_world()), settings);
  if (!player) return tl::unexpected(player.error());
  Person person(**link, **hand, **player);
  const auto& stop = stop_requested();
  for (auto next = clock.now(); !stop && (*laboratory)->alive(); next = std::max(next + kTick, clock.now())) {
    clock.sleep_until(next);
    person.tick(clock.now());
  }
  return {};
}

}  // namespace
}  // namespace palpate::doors

int main(int argc, char** argv) {
  try {
    const auto done = palpate::doors::play({argv + 1, argv + argc});
    if (done) return 0;
    std::fprintf(stderr, "palpate_scripted_player: %s\n", done.error().message.c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpate_scripted_player: %s\n", error.what());
  }
  return 1;
}
