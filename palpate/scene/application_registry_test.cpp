// A registry of guests that behave, and of guests that do not.
#include "palpate/scene/application_registry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include <stdexcept>
#include <string>
#include <vector>

namespace palpate::scene {
namespace {

// A body that stands where the seed, the pause and what is kept say, to see that all arrive.
class Still : public Application {
 public:
  explicit Still(const RunSettings& run) : run_(run) {}
  void step(Instant<PhysicsClock> now, Duration, const TipState&, SceneState& state) override {
    state.time = now;
    state.body_count = 1;
    state.bodies[0].set_p(
        {static_cast<double>(run_.seed), run_.pause_s.value_or(-1.0), run_.keeps_files ? 0.0 : 1.0});
  }
  const ImpactEvent& impact() const override { return impact_; }

 private:
  void begin() override {}
  void reset() override {}
  RunSettings run_;
  ImpactEvent impact_;
};

class Nothing : public SceneView {
 public:
  std::vector<DrawItem> draw(const SceneState&) const override { return {}; }
  std::vector<std::string> captions(const SceneState&) const override { return {"nothing"}; }
};

class Idle : public Player {
 public:
  void show(const SceneState&, Instant<PhysicsClock>) override {}
  device::HandTarget act(Instant<PhysicsClock>) override { return {}; }
  void take_over(const device::HandTarget&, Instant<PhysicsClock>) override {}
};

class Helper : public InputAssist {
 public:
  void show(const SceneState&) override {}
  std::optional<device::HandTarget> act(Instant<PhysicsClock>, const Led&) override { return {}; }
};

ApplicationSpec guest(const std::string& name) {
  ApplicationSpec spec;
  spec.name = name;
  spec.summary = "Stands still";
  spec.make_physics = [](const SceneDescription&, const RunSettings& run) {
    return std::make_unique<Still>(run);
  };
  spec.make_view = [](const SceneDescription&) { return std::make_unique<Nothing>(); };
  return spec;
}

SceneDescription scene_of(const std::string& application, const std::vector<std::string>& surfaces = {}) {
  SceneDescription scene;
  scene.application = application;
  for (const auto& name : surfaces) scene.surfaces.push_back({.name = name, .corners = {}});
  return scene;
}

std::string words_of_adding(ApplicationRegistry& registry, ApplicationSpec spec) {
  try {
    registry.add(std::move(spec));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(ApplicationRegistry, KeepsTheOrderAndFindsByName) {
  ApplicationRegistry registry;
  for (const auto* name : {"still", "a-2nd", "b"}) registry.add(guest(name));
  EXPECT_EQ(registry.names(), (std::vector<std::string>{"still", "a-2nd", "b"}));
  ASSERT_NE(registry.find("b"), nullptr);
  EXPECT_EQ(registry.find("b"), &registry.specs()[2]);
  EXPECT_EQ(registry.find("c"), nullptr);
}

TEST(ApplicationRegistry, TakesNoNameThatIsNoneOrIsTaken) {
  ApplicationRegistry registry;
  registry.add(guest("still"));
  const std::vector<std::string> names{"",          "Still", "2nd",      "-a",
                                       "two words", "a/b",   "\xc3\xa4", std::string(33, 'a')};
  for (const std::string& name : names)
    EXPECT_NE(words_of_adding(registry, guest(name)).find("a name of 1 to 32 lower-case letters"),
              std::string::npos)
        << name;
  EXPECT_EQ(words_of_adding(registry, guest("still")),
            "application 'still': another one has this name; choose a new one");
  EXPECT_EQ(words_of_adding(registry, guest(std::string(32, 'a'))), "");
  EXPECT_EQ(registry.specs().size(), 2u);
}

TEST(ApplicationRegistry, TakesNoGuestWithoutItsParts) {
  ApplicationRegistry registry;
  auto spec = guest("still");
  spec.make_physics = nullptr;
  EXPECT_EQ(words_of_adding(registry, spec), "application 'still': has no make_physics");
  spec = guest("still");
  spec.make_view = nullptr;
  EXPECT_EQ(words_of_adding(registry, spec), "application 'still': has no make_view");
  for (const auto* summary : {"", "two\nlines"}) {
    spec = guest("still");
    spec.summary = summary;
    EXPECT_EQ(words_of_adding(registry, spec), "application 'still': a summary of one line is expected");
  }
  EXPECT_TRUE(registry.specs().empty());
}

TEST(ApplicationRegistry, MakesWhatTheGuestMakes) {
  ApplicationRegistry registry;
  registry.add(guest("still"));
  const auto physics = registry.make_physics(scene_of("still"), {.seed = 7, .pause_s = 0.25});
  ASSERT_TRUE(physics) << physics.error().message;
  SceneState state;
  (*physics)->step(Instant<PhysicsClock>{}, Duration(0), {}, state);
  EXPECT_EQ(state.bodies[0].p(), Vector3(7.0, 0.25, 0.0));
  const auto view = registry.make_view(scene_of("still"));
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_EQ((*view)->captions(state), std::vector<std::string>{"nothing"});
}

TEST(ApplicationRegistry, SaysWhoThereIsWhereANameIsNotKnown) {
  ApplicationRegistry registry;
  EXPECT_EQ(registry.make_view(scene_of("still")).error().message,
            "application 'still' is not known; there are: none");
  registry.add(guest("still"));
  registry.add(guest("other"));
  const auto made = registry.make_physics(scene_of("stil"), {});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().kind, Error::Kind::wrong_use);
  EXPECT_EQ(made.error().message, "application 'stil' is not known; there are: still, other");
}

TEST(ApplicationRegistry, MakesNothingBeforeTheSurfacesAreThere) {
  ApplicationRegistry registry;
  auto spec = guest("still");
  spec.surfaces = {"table", "wall"};
  spec.make_player = [](const auto&...) { return std::make_unique<Idle>(); };
  spec.make_input_assist = [](const auto&...) { return std::make_unique<Helper>(); };
  registry.add(spec);
  const auto lacks = [&registry](const SceneDescription& scene) {
    std::vector<Error> errors;
    if (const auto made = registry.make_physics(scene, {}); !made) errors.push_back(made.error());
    if (const auto made = registry.make_view(scene); !made) errors.push_back(made.error());
    if (const auto made = registry.make_player(scene, {}, {}); !made) errors.push_back(made.error());
    if (const auto made = registry.make_input_assist(scene, {}, {}); !made) errors.push_back(made.error());
    return errors;
  };
  const auto errors = lacks(scene_of("still", {"table"}));
  ASSERT_EQ(errors.size(), 4u);
  for (const auto& error : errors) {
    EXPECT_EQ(error.kind, Error::Kind::refused);
    EXPECT_EQ(error.message,
              "still: the rig has no calibrated surface 'wall'; run `palpate calibrate surface`");
  }
  EXPECT_TRUE(lacks(scene_of("still", {"wall", "cabinet", "table"})).empty());
}

TEST(ApplicationRegistry, APlayerMayBeMissingAndSoMayHelp) {
  ApplicationRegistry registry;
  registry.add(guest("still"));
  const auto player = registry.make_player(scene_of("still"), {}, {});
  ASSERT_FALSE(player);
  EXPECT_EQ(player.error().message,
            "still: has no scripted player; only a person at a window or an arm can play it");
  const auto help = registry.make_input_assist(scene_of("still"), {}, {});
  ASSERT_TRUE(help);
  EXPECT_EQ(*help, nullptr);
}

TEST(ApplicationRegistry, WhatIsExploredMayBeMissingAndIsAMesh) {
  ApplicationRegistry registry;
  registry.add(guest("still"));
  const auto nothing = registry.explored(scene_of("still"));
  ASSERT_TRUE(nothing) << nothing.error().message;
  EXPECT_FALSE(*nothing);
  auto spec = guest("other");
  ExploredSurface surface;
  spec.explored = [&surface](const SceneDescription&) { return surface; };
  registry.add(spec);
  const auto words = [&registry] {
    const auto made = registry.explored(scene_of("other"));
    return made ? std::string() : made.error().message;
  };
  const std::string no_mesh =
      "other: its surface to explore is no mesh; triangles of finite vertices are expected";
  EXPECT_EQ(words(), no_mesh);
  surface.mesh = sphere_mesh(0.05);
  EXPECT_EQ(words(), "");
  surface.mesh.triangles.push_back({0, 1, 1'000'000});
  EXPECT_EQ(words(), no_mesh);
}

TEST(ApplicationRegistry, TakesTablesOfRawAlone) {
  for (const std::string file : {"", ".csv", "a.txt", "../summary.csv", "raw/a.csv"}) {
    ApplicationRegistry registry;
    auto spec = guest("still");
    spec.tables = {{file, "what it did"}};
    EXPECT_EQ(words_of_adding(registry, spec),
              "application 'still': table '" + file + "': a file name that ends in .csv is expected");
    spec.tables = {{"stillness.csv", "what it did"}};
    EXPECT_EQ(words_of_adding(registry, spec), "");
  }
}

TEST(ApplicationRegistry, ARecordMayBeMissingAndThenNothingIsKept) {
  ApplicationRegistry registry;
  registry.add(guest("still"));
  const auto record = registry.make_record(scene_of("still"));
  ASSERT_TRUE(record) << record.error().message;
  (*record)->add_state({});
  EXPECT_TRUE((*record)->tables().empty());
  EXPECT_TRUE((*record)->summary().empty());
  EXPECT_TRUE((*record)->closing_lines({}).empty());
  auto spec = guest("counting");
  spec.make_record = [](const SceneDescription&) -> std::unique_ptr<PlayRecord> {
    throw std::runtime_error("no room to count in");
  };
  registry.add(spec);
  EXPECT_EQ(registry.make_record(scene_of("counting")).error().message, "counting: no room to count in");
}

// Where an application has nothing to show, what it begins with is shown.
TEST(ApplicationRegistry, AnExampleIsTheGuestsOwnOrItsFirstState) {
  ApplicationRegistry registry;
  registry.add(guest("still"));
  const auto begun = registry.example_state(scene_of("still"), {});
  ASSERT_TRUE(begun) << begun.error().message;
  EXPECT_EQ(begun->body_count, 1);
  EXPECT_EQ(begun->bodies[0].p(), Vector3(1.0, -1.0, 1.0)) << "an example leaves no file behind";
  auto spec = guest("posing");
  spec.example_state = [](const SceneDescription&, const Pose<World, Tip>& X_world_tip) {
    SceneState state;
    state.body_count = 2;
    state.bodies[1].set_p(X_world_tip.translation);
    return state;
  };
  spec.example_shape = [](const SceneDescription&, const SceneState& state) {
    return std::vector<float>(6, static_cast<float>(state.bodies[1].p().y()));
  };
  registry.add(spec);
  const auto posed = registry.example_state(scene_of("posing"), {Quaternion::Identity(), {1.0, 2.0, 3.0}});
  ASSERT_TRUE(posed) << posed.error().message;
  EXPECT_EQ(registry.example_shape(scene_of("still"), *begun).value(), nullptr) << "it is at rest";
  EXPECT_EQ(registry.example_shape(scene_of("posing"), *posed).value()->values, std::vector<float>(6, 2.0f));
  EXPECT_EQ(posed->bodies[1].p(), Vector3(1.0, 2.0, 3.0));
  EXPECT_EQ(registry.example_state(scene_of("stil"), {}).error().kind, Error::Kind::wrong_use);
}

TEST(ApplicationRegistry, RefusesInTheGuestsNameWhatTheGuestThrows) {
  ApplicationRegistry registry;
  auto spec = guest("still");
  spec.make_physics = [](const auto&...) -> std::unique_ptr<Application> {
    throw std::invalid_argument("a mass of -1 kg; more than 0 is expected");
  };
  spec.make_view = [](const auto&) -> std::unique_ptr<SceneView> {
    throw std::runtime_error("still: no picture");  // says its name itself
  };
  spec.make_player = [](const auto&...) -> std::unique_ptr<Player> { throw 42; };
  spec.make_input_assist = [](const auto&...) { return std::unique_ptr<InputAssist>(); };
  registry.add(spec);
  const auto scene = scene_of("still");
  const auto physics = registry.make_physics(scene, {});
  ASSERT_FALSE(physics);
  EXPECT_EQ(physics.error().kind, Error::Kind::refused);
  EXPECT_EQ(physics.error().message, "still: a mass of -1 kg; more than 0 is expected");
  EXPECT_EQ(registry.make_view(scene).error().message, "still: no picture");
  EXPECT_EQ(registry.make_player(scene, {}, {}).error().message,
            "still: threw what is no std::exception when its player was made");
  EXPECT_EQ(registry.make_input_assist(scene, {}, {}).error().message,
            "still: made no help for the mouse; one is expected");
}

ApplicationSpec with_speed(const std::string& name, const std::string& section) {
  ApplicationSpec spec = guest(name);
  spec.settings.fields = {
      {.section = section, .key = "speed_m_s", .initial = std::vector<double>{1.0}, .range = {0.0, 3.0}}};
  return spec;
}

TEST(ApplicationRegistry, ASceneIsDescribedByTheApplicationFromItsOwnSettings) {
  ApplicationRegistry registry;
  registry.add(with_speed("slow", "slow"));
  ApplicationSpec fast = with_speed("fast", "fast");
  fast.describe = [](const SettingValues& values, SceneDescription& scene) {
    scene.carried_offset.x() = values.number("fast.speed_m_s");
  };
  registry.add(fast);
  SettingValues values = registry.settings();
  values.set("slow.speed_m_s", 2.0);
  values.set("fast.speed_m_s", 2.5);
  const auto slow_scene = registry.describe("slow", values);
  ASSERT_TRUE(slow_scene) << slow_scene.error().message;
  EXPECT_EQ(slow_scene->application, "slow");
  EXPECT_EQ(from_payload(registry.find("slow")->settings, slow_scene->settings)->number("slow.speed_m_s"),
            2.0);
  EXPECT_EQ(registry.describe("fast", values)->carried_offset.x(), 2.5);
  EXPECT_EQ(registry.describe("fast", SettingValues())->carried_offset.x(), 1.0) << "what lacks is initial";
  values.set("fast.speed_m_s", 4.0);
  EXPECT_NE(registry.describe("fast", values).error().message.find("fast.speed_m_s: is 4"),
            std::string::npos);
  EXPECT_EQ(registry.describe("none", values).error().kind, Error::Kind::wrong_use);
}

TEST(ApplicationRegistry, ASettingHasOneOwner) {
  ApplicationRegistry registry;
  registry.add(with_speed("slow", "motion"));
  try {
    registry.add(with_speed("fast", "motion"));
    FAIL() << "two applications own a setting";
  } catch (const std::invalid_argument& thrown) {
    EXPECT_STREQ(thrown.what(), "application 'fast': setting motion.speed_m_s: two applications claim it");
  }
  EXPECT_EQ(registry.names(), std::vector<std::string>{"slow"});
}

TEST(ApplicationRegistry, WhatADescriptionSaysIsBounded) {
  const auto refusal = [](const std::function<void(SceneDescription&)>& spoil) {
    ApplicationSpec spec = with_speed("guest", "guest");
    spec.describe = [spoil](const SettingValues&, SceneDescription& scene) { spoil(scene); };
    const auto scene = ApplicationRegistry{spec}.describe("guest", {});
    return scene ? std::string() : scene.error().message;
  };
  EXPECT_EQ(refusal([](SceneDescription&) {}), "");
  EXPECT_EQ(refusal([](SceneDescription&) { throw std::runtime_error("no room"); }), "guest: no room");
  EXPECT_EQ(refusal([](SceneDescription& s) { s.bodies.resize(9); }),
            "guest: it describes 9 bodies, at most 8 are expected");
  EXPECT_NE(refusal([](SceneDescription& s) {
              s.bodies = {{"Ball", -1.0}};
            }).find("'Ball' has a mass of -1 kg"),
            std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& s) {
              s.bodies = {{std::string(65, 'b'), 1.0}};
            }).find("at most 64"),
            std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& s) {
              s.settings = {1, std::string(40000, 'x')};
            }).find("40000 bytes"),
            std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& s) { s.carried_offset.x() = std::nan(""); }).find("is not finite"),
            std::string::npos);
}

TEST(ApplicationRegistry, AnOptionHasANameAHelpAndAnEffect) {
  const auto refusal = [](const ApplicationOption& option) {
    ApplicationSpec spec = guest("guest");
    spec.options = {option};
    try {
      ApplicationRegistry{spec};
      return std::string();
    } catch (const std::invalid_argument& thrown) {
      return std::string(thrown.what());
    }
  };
  const auto nothing = [](const std::string&, SettingValues&) { return Expected<void>(); };
  EXPECT_EQ(refusal({.name = "--speed", .help = "How fast", .apply = nothing}), "");
  for (const ApplicationOption& broken :
       {ApplicationOption{.name = "speed", .help = "How fast", .apply = nothing},
        {.name = "--", .help = "How fast", .apply = nothing},
        {.name = "--Speed up", .help = "How fast", .apply = nothing},
        {.name = "--speed", .help = "", .apply = nothing},
        {.name = "--speed", .help = "How fast", .apply = nullptr}})
    EXPECT_NE(refusal(broken).find("application 'guest': option '" + broken.name), std::string::npos)
        << broken.name;
}

TEST(ApplicationRegistry, AStudyHasANameOfItsOwnASummaryAndWhatItRuns) {
  const auto run = [](const StudyRequest&) -> Expected<StudyOutcome> { return StudyOutcome{}; };
  const auto refusal = [](const ApplicationStudy& study) {
    ApplicationSpec first = guest("first"), second = guest("second");
    first.studies = {{.name = "taken",
                      .summary = "Known",
                      .run = [](const StudyRequest&) -> Expected<StudyOutcome> { return StudyOutcome{}; }}};
    second.studies = {study};
    try {
      ApplicationRegistry{first, second};
      return std::string();
    } catch (const std::invalid_argument& thrown) {
      return std::string(thrown.what());
    }
  };
  EXPECT_EQ(refusal({.name = "new", .summary = "One line", .run = run}), "");
  for (const ApplicationStudy& broken :
       {ApplicationStudy{.name = "New one", .summary = "One line", .run = run},
        {.name = "new", .summary = "", .run = run},
        {.name = "new", .summary = "Two\nlines", .run = run},
        {.name = "new", .summary = "One line", .run = nullptr},
        {.name = "taken", .summary = "One line", .run = run}})
    EXPECT_NE(refusal(broken).find("application 'second': study '" + broken.name), std::string::npos)
        << broken.name;
}

}  // namespace
}  // namespace palpate::scene
