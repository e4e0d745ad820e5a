// What the run on two hosts showed, out of what both servers wrote down: summary.json's "realtime/network".
// A pure function.
#pragma once

#include <string>
#include <vector>

#include "palpate/core/csv.h"
#include "palpate/core/expected.h"
#include "palpate/core/json.h"

namespace palpate::evaluation {

// All times in seconds since the graphics server's first frame.
struct NetworkRecords {
  bool encrypted = true;
  std::string physics_address, graphics_place;
  double pulled_s = 0.0, plugged_s = 0.0;
  struct Change {  // what the graphics server says of the physics server
    double time_s = 0.0;
    bool there = false;
  };
  std::vector<Change> server_there;
  CsvTable frames, sync, loops;  // realtime_frames.csv, realtime_sync.csv, realtime_loops.csv
};

// A key is missing where what it counts never came to pass. Refused where a table lacks a column.
Expected<Json> outage_analysis(const NetworkRecords& records);

// realtime_network.csv: what happened when.
std::string network_events(const NetworkRecords& records);

}  // namespace palpate::evaluation
