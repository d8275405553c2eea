#include "server/check_map.h"

#include <sstream>
#include <system_error>
#include <utility>

#include "map/audit.h"
#include "options.h"
#include "storage/map_file.h"

namespace eifmap {
namespace {

std::string in_words(const LoadedMap& map) {
  std::ostringstream out;
  const Map& of = *map.snapshot.map;
  out << "map " << map.head.map_id << " (epoch " << map.head.epoch << ", update "
      << map.head.names.seq << "): keyframes 0 to " << of.num_keyframes() - 1 << ", of which "
      << of.num_keyframes_in_use() << " are in use, " << of.num_landmarks() << " landmarks, "
      << of.filter().num_measurements() << " observations, " << map.snapshot.log.size()
      << " images placed";
  return out.str();
}

// "" or what went wrong.
std::string cut(const std::filesystem::path& file, const RecordScan& scan) {
  std::error_code error;
  const std::filesystem::path beside = file.string() + ".damaged";
  std::filesystem::copy_file(file, beside, error);
  if (error) return "cannot copy it to " + beside.string() + ": " + error.message();
  return cut_to_whole(file, scan);
}

}  // namespace

MapCheck check_map(const std::filesystem::path& file, bool repair) {
  RecordScan scan = scan_records(file);
  MapCheck check;
  std::ostringstream said;
  said << file.string() << ": ";
  if (scan.version > 0)
    said << "version " << scan.version << ", " << scan.records.size() << " records in "
         << scan.whole_bytes << " bytes are whole";
  if (scan.torn_bytes > 0) said << ", " << scan.torn_bytes << " bytes follow that are not";
  if (!scan.ok()) said << (scan.version > 0 ? "; " : "") << scan.detail;
  const bool can_be_cut = scan.torn_bytes > 0 && !scan.records.empty() &&
                          (scan.ok() || scan.reason == Reason::kMapFileDamaged);
  if (can_be_cut && repair) {
    const std::string problem = cut(file, scan);
    said << "; "
         << (problem.empty() ? "cut to what is whole, all of it is in " + file.string() + ".damaged"
                             : problem);
    if (problem.empty()) scan = scan_records(file);
  } else if (can_be_cut) {
    said << "; --repair keeps what is whole";
  }
  const std::string known = scan.detail;
  const LoadedMap map = load_map(std::move(scan), {});
  if (map.ok()) {
    said << "; " << in_words(map);
    const std::vector<std::string> faults = audit(*map.snapshot.map);
    for (const std::string& fault : faults) said << "; " << fault;
    check.ok = faults.empty();
  } else if (map.detail != known) {
    said << "; " << map.detail;
  }
  check.said = said.str();
  return check;
}

}  // namespace eifmap
