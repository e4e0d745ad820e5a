// What the console says to its own page: JSON texts of the WebSocket subprotocol palpate.console.v1, an object each, whose
// "op" is its kind (docs/console.md). Pure; any thread. SI, World; times of the physics clock in ns as decimal text, as a
// browser's numbers do not hold them.
#pragma once

#include <string>
#include <vector>

#include "palpate/scene/application.h"
#include "palpate/scene/scene_state.h"
#include "palpate/transport/shown_picture.h"
#include "tools/console/event_log.h"
#include "tools/console/lights.h"

namespace palpate::tools::console {

inline constexpr const char* kPageProtocol = "palpate.console.v1";

std::string scene_message(const scene::SceneDescription& scene);

// `states`: those since the message before, oldest first; not empty. Of all of them the felt force, of the newest the bodies.
std::string states_message(const std::vector<scene::SceneState>& states);

struct PageFigures {
  std::size_t viewers = 0;                            // of the console
  std::uint64_t states_missed = 0, page_dropped = 0;  // on the way to the console; to this page
  double shown_after_ms =
      0.0;                // median, from the moment of a state until this page had drawn it; 0: not measured
  bool controls = false;  // whether wishes are taken at all
};
std::string status_message(const SystemView& view, const std::vector<Event>& news,
                           const PageFigures& figures);

// As bytes: the length of a JSON head (32 bits, little-endian), the head, a JPEG file.
std::string picture_message(const transport::ShownPicture& picture, std::string_view jpeg);

std::string refusal_message(const std::string& words);

// What a page says.
struct PageSaying {
  enum class Kind { seen, control, other };
  Kind kind = Kind::other;   // other: nothing that is known here
  std::int64_t seen_ns = 0;  // the time of the states that were drawn
  std::string control, token;
};
PageSaying read_page_message(std::string_view text);

}  // namespace palpate::tools::console
