// Pictures of the calibration board from a head that moves around it, its corners found and numbered.
//
// Pixels as CameraModel has them; times are host times. One thread. Errors: the recording's; that the board is in few
// pictures, or in none, is no error here.
#pragma once

#include <optional>
#include <vector>

#include "palpate/calibration/session/procedures.h"
#include "palpate/vision/board.h"

namespace palpate::calibration::session {

struct BoardViewRecord {
  std::vector<vision::BoardView> views;
  ViewRecord record;          // its image_times_s are those of the views
  int width = 0, height = 0;  // px
};

// The board in one picture: its corners found, and numbered from its dark end. Nothing where it is not whole in view.
std::optional<vision::BoardView> find_board(const device::CameraImage& image, const vision::BoardShape& shape,
                                            int half_window = 0);

// One image in `every` is searched.
Expected<BoardViewRecord> record_board_views(AcquisitionContext context, double seconds_long, int every);

}  // namespace palpate::calibration::session
