// A recording shown again, seen by a client as a physics server: the surface that deforms comes as it was recorded.
#include "palpate/server/physics/recording_show.h"

#include <gtest/gtest.h>

#include <future>

#include "palpate/core/text.h"
#include "palpate/record/session/session_recording.h"
#include "palpate/record/session/shape_messages.h"
#include "palpate/time/clock.h"
#include "palpate/transport/messages.h"
#include "palpate/transport/zmq_engine.h"
#include "tests/scratch_folder.h"

namespace palpate::server::physics {
namespace {

constexpr std::size_t kVertices = 50;

// Every number differs; after `dents` the first three vertices have moved so often.
scene::Shape surface(double at_s, int dents) {
  scene::Shape shape{Instant<PhysicsClock>::from_seconds(at_s), {}};
  for (std::size_t i = 0; i < kVertices * scene::Shape::kFloatsPerVertex; ++i)
    shape.values.push_back(0.001f * static_cast<float>(i) +
                           (i < 18 ? 0.3f * static_cast<float>(dents) : 0.0f));
  return shape;
}

struct Dent {
  double at_s;
  int dents;
};

class RecordingShow : public testing::Test {
 protected:
  // 2 s of a world at 50 Hz whose surface is pressed at those times; `broken`: a message of the surface that is none follows.
  void record(const std::vector<Dent>& dents, bool broken = false) {
    auto begun = record::session::SessionRecording::begin(
        file_, {.recorder = "test", .on_error = {}, .wall_time = false});
    ASSERT_TRUE(begun) << begun.error().message;
    scene::SceneDescription scene;
    scene.application = "cloth";
    scene.shape_vertices = kVertices;
    ASSERT_TRUE((*begun)->attach("scene.pb", "application/x-protobuf", transport::encode(scene)));
    auto& states = (*begun)->stream("/physics/state", "palpate.wire.WorldState");
    auto& shapes = (*begun)->stream("/physics/shape", "palpate.recording.Shape");
    record::session::ShapeEncoder encoder;
    std::size_t next = 0;
    for (int i = 0; i < 100; ++i) {
      const double now_s = 0.02 * i;
      const auto time = (*begun)->log_time(Instant<PhysicsClock>::from_seconds(now_s).ns());
      for (; next < dents.size() && dents[next].at_s <= now_s; ++next)
        shapes.write(time, time, encoder.encode(surface(now_s, dents[next].dents)));
      if (broken && i == 10) shapes.write(time, time, "\x10");
      scene::SceneState state;
      state.time = Instant<PhysicsClock>::from_seconds(now_s);
      states.write(time, time, transport::encode(state));
    }
    ASSERT_TRUE((*begun)->finish());
  }

  std::future<Expected<Json>> show(double from_s = 0.0) {
    options_.recording = file_;
    options_.from_s = from_s;
    auto place = serving_place("ipc://" + (folder_ / "show.sock").string(), false, {});
    EXPECT_TRUE(place) << place.error().message;
    options_.place = std::move(*place);
    return std::async(std::launch::async, [this] { return show_recording(options_); });
  }

  // All that come to a client that asks for the newest again and again, each once; until the show is over.
  std::vector<std::vector<float>> seen_during(std::future<Expected<Json>>& show) {
    MonotonicClock<GraphicsClock> clock;
    auto link = transport::connect_states(options_.place.endpoint, clock);
    EXPECT_TRUE(link) << link.error().message;
    std::vector<std::vector<float>> seen;
    for (std::uint64_t number = 1; show.wait_for(std::chrono::milliseconds(5)) != std::future_status::ready;
         ++number) {
      (*link)->request(number, Instant<PhysicsClock>::from_seconds(1e9), true);
      (*link)->poll();
      const auto& shape = (*link)->newest_shape();
      if (shape && (seen.empty() || seen.back() != shape->values)) seen.push_back(shape->values);
    }
    return seen;
  }

  ScratchFolder folder_;
  std::filesystem::path file_ = folder_ / "session.mcap";
  ShowOptions options_;
};

TEST_F(RecordingShow, TheSurfaceThatDeformsComesAsItWas) {
  record({{0.0, 0}, {0.8, 1}, {1.4, 2}});
  auto shown = show();
  const auto seen = seen_during(shown);
  const auto figures = shown.get();
  ASSERT_TRUE(figures) << figures.error().message;
  ASSERT_EQ(seen.size(), 3u);
  for (int dents = 0; dents < 3; ++dents)
    EXPECT_EQ(seen[static_cast<std::size_t>(dents)], surface(0.0, dents).values) << dents;
}

TEST_F(RecordingShow, BegunInTheMiddleItKnowsWhatWasPressedBefore) {
  record({{0.0, 0}, {0.4, 1}, {0.6, 2}});
  auto shown = show(1.0);
  const auto seen = seen_during(shown);
  ASSERT_TRUE(shown.get());
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0], surface(0.0, 2).values);
}

TEST_F(RecordingShow, AMessageOfTheSurfaceThatIsNoneIsNamed) {
  record({{0.0, 0}}, true);
  auto shown = show();
  const auto figures = shown.get();
  ASSERT_FALSE(figures);
  EXPECT_NE(figures.error().message.find("Shape"), std::string::npos) << figures.error().message;
}

}  // namespace
}  // namespace palpate::server::physics
