// A file of records, each of which is there as a whole or not at all, whatever moment the power or
// the process goes: it is read up to the last whole one.
//
//   header: "EIFMAP\r\n", u32 version, u32 0, u64 name of the file, u64 hash of these
//   record: u32 kRecordMark, u32 0, u64 number (from 0), u64 size, u64 hash, bytes
//
// A record's hash is of its number, its size and its bytes, seeded with the file's name: what is
// left of another file on the disk is no record of this one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "reason.h"

namespace eifmap {

inline constexpr std::uint32_t kFileVersion = 1;

struct RecordScan {
  Reason reason = Reason::kNone;  // kNone: the file can be read. kMapFileUnreadable,
                                  // kMapFileUnknown, kMapFileNewer, kMapFileDamaged
  std::string detail;             // what is wrong, where, in words
  std::uint32_t version = 0;
  std::uint64_t name = 0;
  std::vector<std::uint8_t> bytes;                     // of the whole file
  std::vector<std::span<const std::uint8_t>> records;  // whole ones from the first on; in `bytes`
  std::size_t whole_bytes = 0;                         // of the header and these
  // Something follows that is no whole record: as after a crash in the middle of writing. With a
  // whole record after it, it is damage, and the reason says so.
  std::size_t torn_bytes = 0;

  bool ok() const { return reason == Reason::kNone; }
};

// Never throws on what a file may hold.
RecordScan scan_records(const std::filesystem::path& file);
RecordScan scan_records(std::vector<std::uint8_t> bytes);

// Cuts off what follows the last whole record before any damage, and flushes. "" or what went
// wrong.
std::string cut_to_whole(const std::filesystem::path& file, const RecordScan& scan);

// The bytes of such a file of one record.
std::vector<std::uint8_t> record_file(std::uint64_t name, std::span<const std::uint8_t> record);

// Writes such a file. All functions return "" or what went wrong, with the system's words; the file
// is then as it was before the call.
class RecordWriter {
 public:
  RecordWriter() = default;
  ~RecordWriter() { close(); }
  RecordWriter(const RecordWriter&) = delete;
  RecordWriter& operator=(const RecordWriter&) = delete;

  // A new file with this first record in the place of what may be there, at once: until that is on
  // the disk the old one is. `name`: one that no other file has.
  std::string replace(const std::filesystem::path& file, std::uint64_t name,
                      std::span<const std::uint8_t> first);
  // Returns when the record is on the disk.
  std::string append(std::span<const std::uint8_t> record);

  bool is_open() const { return descriptor_ >= 0; }
  std::uint64_t size() const { return size_; }  // bytes
  void close();

 private:
  int descriptor_ = -1;
  std::uint64_t name_ = 0, number_ = 0, size_ = 0;
};

}  // namespace eifmap
