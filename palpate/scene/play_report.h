// An application's part of a demo's page, as data: words, key figures and whole sections. Made from what the play
// left in its folder, so that a page can be made again at any time. Values.
#pragma once

#include <string>
#include <vector>

#include "palpate/figures/section.h"

namespace palpate::scene {

struct PlayReport {
  std::string title;  // of the page: "Palpate: ping-pong you can see and feel"
  std::string task;   // what is done in a play, after "calibrate everything,": "play ping-pong"
  std::string scene;  // what is real here and what is not, and what the hand feels; whole sentences
  std::string drawn;  // what is drawn into the camera's picture: "ball and racket"
  std::string force_label = "Strongest force the hand felt";
  std::vector<figures::Figure> figures;    // among the page's first
  std::vector<figures::Section> sections;  // after those on the calibration and the exchange
};

}  // namespace palpate::scene
