// The applications that a program has, each under its name: what it puts on the physics side and on the graphics
// side, and how a hand deals with it. Everything that the system knows of an application stands in its
// ApplicationSpec; a program fills a registry once and hands it to its servers, which know no other way to one.
//
// A registry is filled in one thread; from then on it is read, from any thread. Errors: add() throws for a
// specification that cannot be used, as a broken set-up; make_*() refuse, whatever a guest throws included.
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/figures/page_file.h"
#include "palpate/figures/play_folder.h"
#include "palpate/scene/application.h"
#include "palpate/scene/application_option.h"
#include "palpate/scene/application_study.h"
#include "palpate/scene/explored_surface.h"
#include "palpate/scene/play_record.h"
#include "palpate/scene/play_report.h"
#include "palpate/scene/player.h"
#include "palpate/scene/setting_schema.h"
#include "palpate/scene/shape.h"

namespace palpate::scene {

// What one run asks of the physics side beside the scene.
struct RunSettings {
  std::uint64_t seed = 1;
  // For people: so long a pause lies between two rounds, s, and a round lasts as long as the person keeps it
  // going. None: rounds follow each other as the scripted player likes them.
  std::optional<double> pause_s;
  // False where nothing that people keep over sessions may be written, nor be needed: a recording that is executed again, an
  // example that is drawn.
  bool keeps_files = true;
};

// What the hand holds and what it does with that: words on the screen and in the list of keys, and how a mouse
// leads it. Words are in lower case, without an article where none is shown.
struct Handling {
  std::string held = "stylus";  // "racket": the person moves "the racket"
  std::string plays = "play";   // "let the program play"
  std::string faces{};          // the surface that what is held is turned to; empty: it hangs down
  std::string buttons = "turn the stylus";  // what the mouse's buttons do
  std::string begins{};                     // what Space begins: "round"; empty: it is not listed
};

// An application, as it tells of itself. Who adds a field gives it a default: it may be left out.
struct ApplicationSpec {
  std::string name{};     // lower-case letters, digits and '-', a letter first; at most kLongestName of them
  std::string summary{};  // one line for a person
  std::vector<std::string> surfaces{};  // of the rig, which must be calibrated before anything is made
  Handling handling{};
  SettingSchema settings{};  // what a person may set in a file
  // Fills what a scene says of the application: carried_offset, bodies, mesh, and its settings as a payload, for
  // values that check() has passed. Empty: to_payload() alone.
  std::function<void(const SettingValues&, SceneDescription&)> describe{};
  std::vector<ApplicationOption> options{};  // of the command line; applied in this order
  // Changes settings to what a person at a window can begin with; empty: they are so already.
  std::function<void(SettingValues&)> ease_for_a_person{};
  // Changes settings that nobody has set so that quick_demo_s shows all of it; empty: it does.
  std::function<void(SettingValues&)> shorten_for_a_quick_demo{};

  // Any of these may throw for settings that cannot be, and says what is expected. They get a scene whose
  // surfaces are there.
  std::function<std::unique_ptr<Application>(const SceneDescription&, const RunSettings&)> make_physics{};
  std::function<std::unique_ptr<SceneView>(const SceneDescription&)> make_view{};
  // Plays in a person's place; empty: nobody does.
  std::function<std::unique_ptr<Player>(const SceneDescription&, const Reach&, const PlayerSettings&)>
      make_player{};
  // Helps a person who plays with the mouse; empty: there is no need of it.
  std::function<std::unique_ptr<InputAssist>(const SceneDescription&, const Reach&, const PlayerSettings&)>
      make_input_assist{};
  // What a hand explores with the tip, where it does so: the mouse then leads the tip over it and presses with a
  // button. Empty: the mouse leads what is held over a plane.
  std::function<ExploredSurface(const SceneDescription&)> explored{};

  // For those who look at a play afterwards; each may be left out.
  std::vector<PlayTable> tables{};  // what the record adds to raw/
  std::function<std::unique_ptr<PlayRecord>(const SceneDescription&)> make_record{};
  std::function<PlayReport(const figures::PlayFolder&)> report{};
  // Words, limits and templates of its part of the page, all optional: NAME.toml, NAME-limits.toml,
  // NAME-figures.html, NAME-sections.html.
  figures::PageFiles page{};
  // A state worth a picture, with the stylus there; empty: the one that the application begins with.
  std::function<SceneState(const SceneDescription&, const Pose<World, Tip>&)> example_state{};
  // The surface that deforms as it is in that state, Application::shape; empty: it is drawn at rest.
  std::function<std::vector<float>(const SceneDescription&, const SceneState&)> example_shape{};

  std::vector<ApplicationStudy> studies{};  // `palpate study NAME`, in this order

  // How long a demo plays in lock-step where nobody says, s: enough for something to happen; 0: the demo's own length.
  double demo_s = 0.0, quick_demo_s = 0.0;
};

class ApplicationRegistry {
 public:
  static constexpr std::size_t kLongestName = 32;

  ApplicationRegistry() = default;
  ApplicationRegistry(std::initializer_list<ApplicationSpec> specs) {
    for (const auto& spec : specs) add(spec);
  }

  // Throws std::invalid_argument, which names the application: a name that is no such, or is taken; a summary of
  // no or several lines; no physics side or no view; a setting that another one has; an option that is none; a study
  // without a name, a summary of one line or anything to run, or with the name of another application's.
  void add(ApplicationSpec spec);

  // Null where there is none. Valid until the next add().
  const ApplicationSpec* find(std::string_view name) const;
  const std::vector<ApplicationSpec>& specs() const { return specs_; }  // in the order they were added
  std::vector<std::string> names() const;
  // Of an application that is not known: the bare stylus.
  const Handling& handling(std::string_view name) const;
  // Of all applications, at their initial values.
  SettingValues settings() const;
  // What complaints there are about values that hold the settings of all.
  std::vector<SettingComplaint> complaints(const SettingValues& values) const;

  // The scene of an application but for its surfaces, which are the rig's. Wrong use for a name that is not
  // known, and for values out of range; those that `values` lacks are the initial ones. Refused where the
  // application throws, or says more than a message holds (transport/messages.h).
  Expected<SceneDescription> describe(std::string_view application, const SettingValues& values) const;

  // The application of the scene. Wrong use for a name that is not known; refused where the scene lacks a surface
  // that it needs, and where it throws or makes nothing.
  Expected<std::unique_ptr<Application>> make_physics(const SceneDescription& scene,
                                                      const RunSettings& run) const;
  Expected<std::unique_ptr<SceneView>> make_view(const SceneDescription& scene) const;
  // Refused where nobody plays it.
  Expected<std::unique_ptr<Player>> make_player(const SceneDescription& scene, const Reach& reach,
                                                const PlayerSettings& settings) const;
  // Null where it has no need of one.
  Expected<std::unique_ptr<InputAssist>> make_input_assist(const SceneDescription& scene, const Reach& reach,
                                                           const PlayerSettings& settings) const;
  // None where there is nothing to explore. Refused where its mesh is none.
  Expected<std::optional<ExploredSurface>> explored(const SceneDescription& scene) const;
  // One that keeps nothing where the application has no record of its own.
  Expected<std::unique_ptr<PlayRecord>> make_record(const SceneDescription& scene) const;
  // With the stylus there, at rest.
  Expected<SceneState> example_state(const SceneDescription& scene,
                                     const Pose<World, Tip>& X_world_tip) const;
  // Its surface that deforms; null where it is at rest, or there is none.
  Expected<std::shared_ptr<const Shape>> example_shape(const SceneDescription& scene,
                                                       const SceneState& state) const;

 private:
  Expected<const ApplicationSpec*> known(std::string_view name) const;
  Expected<const ApplicationSpec*> ready(const SceneDescription& scene) const;
  std::vector<ApplicationSpec> specs_;
};

}  // namespace palpate::scene
