#include "palpate/scene/play_record.h"

namespace palpate::scene {

bool ShownPicture::shows(const Vector3& point) const {
  const auto pixel = device::drawn_pixel(lens, X_world_camera, point);
  return pixel && pixel->x() >= 0.0 && pixel->x() <= lens.width && pixel->y() >= 0.0 &&
         pixel->y() <= lens.height;
}

Highlight PlayRecord::highlight(const ShownPicture& picture) const {
  const auto& first = picture.state.bodies[0];
  const bool drawn = picture.have_state && picture.state.body_count > 0 && first.visible != 0;
  return {.in_sight = drawn && picture.shows(first.p()),
          .event = "event",
          .going_on = "the play goes on",
          .unseen = "the play goes on, out of the picture"};
}

}  // namespace palpate::scene
