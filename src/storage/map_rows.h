// A map to rows, and back.
#pragma once

#include <string>

#include "map/map_snapshot.h"
#include "storage/map_fields.h"
#include "storage/rows.h"

namespace eifmap {

// Puts into the book what may be others than `before`, which is in it already (null: nothing is).
// What the two share is not looked at.
void put_map(const MapSnapshot& now, const MapSnapshot* before, const MapNames& names,
             RowBook& book);

struct ReadMap {
  std::string problem;  // "" or why there is no map in these rows
  MapHead head;
  MapContents contents;
  TrajectoryLog log;
  std::vector<int> most_tracked;
};

// Only what the rows say; whether it fits together problem_of(contents) says.
ReadMap read_map(const RowSet& rows);

}  // namespace eifmap
