#include "storage/map_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "frame_check.h"
#include "storage/map_writer.h"

namespace eifmap {
namespace {

// What a file can say of how many: more is no map. Of those that are no more there is nothing in
// it, and a camera that never rests makes ten thousand a minute.
constexpr std::uint32_t kMostTracks = 500'000'000;

constexpr std::size_t kLogPiece = TrajectoryLog::Entries::piece_size();

class MapReader {
 public:
  MapReader(const RowSet& rows, ReadMap& read) : rows_(rows), read_(read) {}

  std::string problem() {
    if (!read_row(Table::kMap, 0, [&](auto& in) { fields::head(in, read_.head); }))
      return "it has no head";
    if (std::string problem = read_.head.names.camera.problem(); !problem.empty())
      return "its calibration: " + problem;
    const MapHead& h = read_.head;
    if (h.map_sign != MapSign::kMinus && h.map_sign != MapSign::kPlus &&
        h.map_sign != MapSign::kBoth)
      return "it is of no sign";
    if (h.tracks > kMostTracks) return "its head asks for more than fits a map";
    if (h.keyframes > rows_.size() || h.logged > kLogPiece * rows_.size())
      return "it has not all of its keyframes";
    read_.contents.map_sign = h.map_sign;
    read_.contents.num_bends = h.num_bends;
    for (auto step : {&MapReader::keyframes, &MapReader::tracks, &MapReader::measurements,
                      &MapReader::books, &MapReader::places, &MapReader::log})
      if (std::string problem = (this->*step)(); !problem.empty()) return problem;
    return "";
  }

 private:
  // False where there is no such row, or it is not whole.
  template <class Visit>
  bool read_row(Table table, std::uint32_t number, Visit visit) const {
    if (!rows_.has({table, number})) return false;
    ByteReader in(rows_[{table, number}]);
    visit(in);
    return in.is_whole();
  }
  template <class Element, class Visit>
  std::string read_table(Table table, const char* what, std::uint32_t count,
                         std::vector<Element>& elements, Visit visit) const {
    if (count > rows_.size()) return std::string("it has not all of its ") + what;
    elements.resize(count);
    for (std::uint32_t n = 0; n < count; ++n)
      if (!read_row(table, n, [&](auto& in) { visit(in, elements[n]); }))
        return std::string(what) + " " + std::to_string(n) + " is missing or not whole";
    return "";
  }

  std::string keyframes() {
    const MapHead& h = read_.head;
    if (std::string problem =
            read_table(Table::kKeyframe, "keyframes", h.keyframes, read_.contents.keyframes,
                       [](auto& in, auto& k) { fields::keyframe(in, k); });
        !problem.empty())
      return problem;
    for (std::uint32_t k = 0; k < h.keyframes; ++k) {
      MapContents::OfKeyframe& keyframe = read_.contents.keyframes[k];
      if (keyframe.carrier >= 0) continue;
      FeatureFrame frame;
      double sigma_factor = 0;
      if (!read_row(Table::kFrame, k, [&](auto& in) {
            in(sigma_factor);
            fields::frame(in, frame);
          }))
        return "the image of keyframe " + std::to_string(k) + " is missing or not whole";
      frame.camera = "";
      if (!check_frame(frame, h.names.camera).ok() || !(sigma_factor > 0) ||
          !std::isfinite(sigma_factor))
        return "the image of keyframe " + std::to_string(k) + " is none";
      keyframe.frame = std::make_shared<const ObservedFrame>(
          observe(frame, h.names.camera, h.map_sign, sigma_factor));
    }
    return "";
  }

  // Those that are no more have no row, and their numbers are not used again.
  std::string tracks() {
    read_.contents.num_tracks = static_cast<int>(read_.head.tracks);
    for (const std::uint32_t t : rows_.numbers(Table::kTrack)) {
      MapContents::OfTrack& track = read_.contents.tracks.emplace_back();
      if (t >= read_.head.tracks) return "it has more tracks than its head says";
      track.number = static_cast<int>(t);
      if (!read_row(Table::kTrack, t, [&](auto& in) {
            in(track.is_landmark);
            if (track.is_landmark) in(track.position);
            fields::sights(in, track.sights);
          }))
        return "track " + std::to_string(t) + " is not whole";
    }
    return "";
  }

  std::string measurements() {
    MapContents& contents = read_.contents;
    std::string problem =
        read_table(Table::kFilterEdge, "relative poses", read_.head.filter_edges,
                   contents.filter_edges, [](auto& in, auto& e) { fields::relative_pose(in, e); });
    if (problem.empty())
      problem = read_table(Table::kEdge, "edges", read_.head.edges, contents.edges,
                           [](auto& in, auto& e) { fields::edge(in, e); });
    if (problem.empty())
      problem = read_table(Table::kAbsolute, "absolute measurements", read_.head.absolutes,
                           contents.absolutes, [](auto& in, auto& a) { fields::absolute(in, a); });
    return problem;
  }

  std::string books() {
    const bool whole =
        read_row(Table::kBooks, 0,
                 [&](auto& in) {
                   fields::filter_books(in, read_.contents.filter);
                   fields::noise_books(in, read_.contents.noise);
                 }) &&
        read_row(Table::kScale, 0, [&](auto& in) { fields::scale(in, read_.contents.scale); }) &&
        read_row(Table::kTracked, 0, [&](auto& in) { visit_plain(in, read_.most_tracked); });
    return whole ? "" : "its books are missing or not whole";
  }

  std::string places() {
    if (!rows_.has({Table::kWords, 0})) return "";
    constexpr std::size_t kWordsSize = std::size_t{kWordsPerSign} * kDescriptorSize;
    const auto is_learnt = [](const Words& w) { return w.empty() || w.size() == kWordsSize; };
    SplitWords words;
    if (!read_row(Table::kWords, 0, [&](auto& in) { fields::words(in, words); }) ||
        !is_learnt(words.minus) || !is_learnt(words.plus))
      return "the words of its index of places are none";
    read_.contents.places.words = std::make_shared<const SplitWords>(std::move(words));
    for (std::uint32_t k = 0; k < read_.head.keyframes; ++k) {
      if (read_.contents.keyframes[k].carrier >= 0) continue;
      std::pair<int, Signature> of{static_cast<int>(k), {}};
      if (!read_row(Table::kSignature, k,
                    [&](auto& in) { in.take(of.second.data(), of.second.size()); }))
        return "keyframe " + std::to_string(k) + " is not in its index of places";
      read_.contents.places.signatures.push_back(of);
    }
    return "";
  }

  std::string log() {
    const auto n = static_cast<int>(read_.head.keyframes);
    std::vector<TrajectoryLog::Entry> entries;
    for (std::uint32_t first = 0; first < read_.head.logged; first += kLogPiece) {
      const auto piece = static_cast<std::uint32_t>(first / kLogPiece);
      if (!read_row(Table::kLog, piece, [&](auto& in) {
            visit_all(in, entries, 60, [](auto& from, auto& e) { fields::logged(from, e); });
          }))
        return "its trajectory is missing or not whole";
      for (const TrajectoryLog::Entry& e : entries) {
        if (e.keyframe < 0 || e.keyframe >= n) return "its trajectory is of other keyframes";
        read_.log.add(e.time_us, e.keyframe, e.keyframe_from_camera);
      }
    }
    if (read_.log.size() != read_.head.logged) return "its trajectory is not whole";
    if (read_.most_tracked.size() != read_.head.keyframes || read_.head.reference < 0 ||
        read_.head.reference >= n)
      return "its books are of other keyframes";
    return "";
  }

  const RowSet& rows_;
  ReadMap& read_;
};

}  // namespace

void put_map(const MapSnapshot& now, const MapSnapshot* before, const MapNames& names,
             RowBook& book) {
  MapWriter(now, before, book).put(names);
}

ReadMap read_map(const RowSet& rows) {
  ReadMap read;
  read.problem = MapReader(rows, read).problem();
  return read;
}

}  // namespace eifmap
