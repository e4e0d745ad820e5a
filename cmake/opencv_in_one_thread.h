// Included first of all, with the thread sanitizer, where a module uses OpenCV: its loops run in their caller's thread.
// The packaged OpenCV and TBB are not built with that sanitizer, which therefore takes each of their hand-overs for a race.
#pragma once

#include <opencv2/core/utility.hpp>

inline const bool opencv_runs_in_one_thread = (cv::setNumThreads(1), true);
