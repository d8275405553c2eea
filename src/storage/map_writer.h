// Puts a map's rows into a book: for map_rows.cpp.
#pragma once

#include "map/map_snapshot.h"
#include "storage/map_fields.h"
#include "storage/rows.h"

namespace eifmap {

class MapWriter {
 public:
  MapWriter(const MapSnapshot& now, const MapSnapshot* before, RowBook& book)
      : now_(now), map_(*now.map), before_(before), book_(book) {}
  void put(const MapNames& names);

 private:
  template <class Visit>
  void put_row(Table table, std::size_t number, Visit visit);
  void erase_beyond(Table table, std::size_t count, std::size_t count_before);
  void put_head(const MapNames& names);
  void put_keyframes();
  void put_tracks();
  void put_track(int track);
  void put_measurements();
  void put_absolutes();
  void put_books();
  void put_log();
  const Map* map_before() const { return before_ ? before_->map.get() : nullptr; }

  const MapSnapshot& now_;
  const Map& map_;
  const MapSnapshot* before_;
  RowBook& book_;
  ByteWriter row_;
};

}  // namespace eifmap
