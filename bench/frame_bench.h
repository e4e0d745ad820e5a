// The parts of bench/frame: each prints its table and returns an exit code.
#pragma once

namespace palpate::bench {

int camera_pictures();     // the simulated camera
int augmented_pictures();  // the compositor beside cv::remap

}  // namespace palpate::bench
