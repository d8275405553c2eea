// A map as rows of tables: a file's record is the rows that have become others since the record
// before, and a digest of all rows as they are then. So a file that is read is the map that was
// written, or is known not to be.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "storage/byte_stream.h"

namespace eifmap {

enum class Table : std::uint8_t {
  kMap = 0,         // one row: names, sizes
  kFrame = 1,       // by keyframe: the image's features
  kKeyframe = 2,    // by keyframe: its pose, or what carries it
  kTrack = 3,       // by track: its sights, and its place
  kFilterEdge = 4,  // relative poses that the filter holds
  kEdge = 5,        // what they, and those before, have used
  kAbsolute = 6,    // absolute measurements that the filter holds
  kBooks = 7,       // one row: the filter's, and the noise's
  kScale = 8,       // one row
  kWords = 9,       // one row: of the index of places, once it is ready
  kSignature = 10,  // by keyframe: what the words make of it
  kLog = 11,        // by 64 frames: where each was
  kTracked = 12     // one row: by keyframe, the landmarks tracked from there at most
};

struct RowKey {
  Table table = Table::kMap;
  std::uint32_t number = 0;
  bool operator==(const RowKey&) const = default;
  std::uint64_t packed() const { return static_cast<std::uint64_t>(table) << 32 | number; }
};

using RowBytes = std::span<const std::uint8_t>;

// What a record holds, and how it is made: rows that are as they were are left out.
class RowBook {
 public:
  // Rows of the record to come. A row is put at most once in each.
  void put(RowKey key, RowBytes row);
  void erase(RowKey key);
  // The record of what was put and erased since the last call of keep() or drop().
  std::vector<std::uint8_t> record() const;
  bool has_changes() const { return !changes_.empty(); }
  void keep();  // it has been written
  void drop();  // it has not

  std::uint64_t digest() const { return digest_; }
  std::size_t size() const { return hashes_.size(); }

 private:
  struct Change {
    RowKey key;
    std::uint64_t hash = 0;  // 0: erased
  };
  std::unordered_map<std::uint64_t, std::uint64_t> hashes_;  // as written, by packed key
  std::uint64_t digest_ = 0;                                 // the sum of these
  std::vector<Change> changes_;
  ByteWriter rows_;
};

// All rows of a file.
class RowSet {
 public:
  // Takes over a record's rows, which must outlive this. "" or what is wrong with it.
  std::string add(RowBytes record);
  // As the last record has it: "" or what is wrong.
  std::string problem() const;

  bool has(RowKey key) const { return rows_.contains(key.packed()); }
  RowBytes operator[](RowKey key) const;  // empty where there is none
  std::size_t size() const { return rows_.size(); }
  std::vector<std::uint32_t> numbers(Table table) const;  // of its rows, ascending

 private:
  std::unordered_map<std::uint64_t, RowBytes> rows_;
  std::uint64_t digest_ = 0;
};

}  // namespace eifmap
