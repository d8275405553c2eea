#include "storage/map_writer.h"

#include <algorithm>
#include <utility>

namespace eifmap {
namespace {

MapContents::OfEdge of_filter(const FilterEdge& edge) {
  return {edge.i, edge.j, edge.measurement};
}

// The elements of pieces that the vector from before does not share; null: all.
template <class Vector, class Visit>
void for_changed(const Vector& now, const Vector* before, Visit visit) {
  constexpr std::size_t kPiece = Vector::piece_size();
  for (std::size_t first = 0; first < now.size(); first += kPiece) {
    if (before && now.shares_piece(first, *before)) continue;
    for (std::size_t i = first; i < std::min(first + kPiece, now.size()); ++i) visit(i);
  }
}

}  // namespace

template <class Visit>
void MapWriter::put_row(Table table, std::size_t number, Visit visit) {
  row_.clear();
  visit(row_);
  book_.put({table, static_cast<std::uint32_t>(number)}, row_.bytes());
}

void MapWriter::erase_beyond(Table table, std::size_t count, std::size_t count_before) {
  for (std::size_t n = count; n < count_before; ++n)
    book_.erase({table, static_cast<std::uint32_t>(n)});
}

void MapWriter::put(const MapNames& names) {
  put_head(names);
  put_keyframes();
  put_tracks();
  put_measurements();
  put_absolutes();
  put_books();
  put_log();
}

void MapWriter::put_head(const MapNames& names) {
  MapHead head;
  head.map_id = now_.map_id;
  head.epoch = now_.epoch;
  head.names = names;
  head.map_sign = map_.map_sign();
  head.reference = now_.reference;
  head.removed_keyframes = now_.removed_keyframes;
  head.removed_landmarks = now_.removed_landmarks;
  head.num_bends = map_.num_bends();
  head.keyframes = static_cast<std::uint32_t>(map_.num_keyframes());
  head.tracks = static_cast<std::uint32_t>(map_.num_tracks());
  head.filter_edges = static_cast<std::uint32_t>(map_.filter().num_edges());
  head.edges = static_cast<std::uint32_t>(map_.edges().size());
  head.absolutes = static_cast<std::uint32_t>(map_.filter().absolutes().size());
  head.logged = static_cast<std::uint32_t>(now_.log.size());
  put_row(Table::kMap, 0, [&](auto& out) { fields::head(out, head); });
}

// What was seen never changes, and is by far the most.
void MapWriter::put_keyframes() {
  const Map* before = map_before();
  const PlaceIndex& places = map_.places();
  const bool new_words = places.ready() && !(before && before->places().words() == places.words());
  if (new_words) put_row(Table::kWords, 0, [&](auto& out) { fields::words(out, *places.words()); });
  for (int k = 0; k < map_.num_keyframes(); ++k) {
    const Keyframe& keyframe = map_.keyframe(k);
    const bool known = before && k < before->num_keyframes();
    const bool same_frame = known && before->keyframe(k).frame == keyframe.frame;
    MapContents::OfKeyframe row;
    row.time_us = keyframe.time_us;
    row.pose = map_.pose(k);
    row.carrier = keyframe.carrier;
    row.carrier_from_this = keyframe.carrier_from_this;
    put_row(Table::kKeyframe, k, [&](auto& out) { fields::keyframe(out, row); });
    const auto number = static_cast<std::uint32_t>(k);
    if (keyframe.removed()) {
      book_.erase({Table::kFrame, number});
      book_.erase({Table::kSignature, number});
      continue;
    }
    if (!same_frame)
      put_row(Table::kFrame, k, [&](auto& out) {
        out(keyframe.observed().sigma_factor);
        fields::frame(out, keyframe.observed().frame);
      });
    if (places.ready() && (new_words || !same_frame)) {
      const Signature& signature = places.signature(k);
      put_row(Table::kSignature, k,
              [&](auto& out) { out.append(signature.data(), signature.size()); });
    }
  }
  const auto n = static_cast<std::size_t>(map_.num_keyframes());
  const auto n_before = before ? static_cast<std::size_t>(before->num_keyframes()) : 0;
  for (const Table table : {Table::kKeyframe, Table::kFrame, Table::kSignature})
    erase_beyond(table, n, n_before);
}

void MapWriter::put_track(int t) {
  const Track& track = map_.track(t);
  if (track.sights.empty()) return book_.erase({Table::kTrack, static_cast<std::uint32_t>(t)});
  put_row(Table::kTrack, t, [&](auto& out) {
    out(track.is_landmark());
    if (track.is_landmark()) out(map_.position(t));
    fields::sights(out, track.sights);
  });
}

void MapWriter::put_tracks() {
  const Map* before = map_before();
  std::vector<int> stale;
  for_changed(map_.tracks(), before ? &before->tracks() : nullptr,
              [&](std::size_t t) { stale.push_back(static_cast<int>(t)); });
  for_changed(map_.filter().landmarks(), before ? &before->filter().landmarks() : nullptr,
              [&](std::size_t l) { stale.push_back(map_.track_of_landmark(static_cast<int>(l))); });
  std::sort(stale.begin(), stale.end());
  stale.erase(std::unique(stale.begin(), stale.end()), stale.end());
  for (const int t : stale) put_track(t);
  erase_beyond(Table::kTrack, static_cast<std::size_t>(map_.num_tracks()),
               before ? static_cast<std::size_t>(before->num_tracks()) : 0);
}

void MapWriter::put_measurements() {
  const Map* before = map_before();
  const FilterEdges& poses = map_.filter().edges();
  for_changed(poses, before ? &before->filter().edges() : nullptr, [&](std::size_t e) {
    put_row(Table::kFilterEdge, e,
            [edge = of_filter(poses[e])](auto& out) { fields::relative_pose(out, edge); });
  });
  erase_beyond(Table::kFilterEdge, poses.size(), before ? before->filter().edges().size() : 0);
  const MapEdges& edges = map_.edges();
  for_changed(edges, before ? &before->edges() : nullptr, [&](std::size_t e) {
    put_row(Table::kEdge, e, [&](auto& out) { fields::edge(out, edges[e]); });
  });
  erase_beyond(Table::kEdge, edges.size(), before ? before->edges().size() : 0);
}

void MapWriter::put_absolutes() {
  const std::vector<FilterAbsolute>& absolutes = map_.filter().absolutes();
  for (std::size_t a = 0; a < absolutes.size(); ++a) {
    AbsoluteObservation row = absolutes[a].observation;
    if (row.kind == AbsoluteObservation::Kind::kLandmarks)
      for (int& landmark : row.landmarks) landmark = map_.track_of_landmark(landmark);
    put_row(Table::kAbsolute, a, [&](auto& out) { fields::absolute(out, row); });
  }
  erase_beyond(Table::kAbsolute, absolutes.size(),
               map_before() ? map_before()->filter().absolutes().size() : 0);
}

void MapWriter::put_books() {
  put_row(Table::kBooks, 0, [&](auto& out) {
    const FilterBooks filter = map_.filter().books();
    const NoiseBooks noise = map_.noise().books();
    fields::filter_books(out, filter);
    fields::noise_books(out, noise);
  });
  put_row(Table::kScale, 0, [&](auto& out) { fields::scale(out, map_.scale()); });
  put_row(Table::kTracked, 0, [&](auto& out) { visit_plain(out, now_.most_tracked); });
}

void MapWriter::put_log() {
  const TrajectoryLog::Entries& entries = now_.log.entries();
  constexpr std::size_t kPiece = TrajectoryLog::Entries::piece_size();
  const auto pieces = [](std::size_t n) { return (n + kPiece - 1) / kPiece; };
  for (std::size_t first = 0; first < entries.size(); first += kPiece) {
    if (before_ && before_->log.entries().size() >= first + kPiece &&
        entries.shares_piece(first, before_->log.entries()))
      continue;
    const std::size_t end = std::min(first + kPiece, entries.size());
    put_row(Table::kLog, first / kPiece, [&](auto& out) {
      out.size(end - first);
      for (std::size_t e = first; e < end; ++e) fields::logged(out, entries[e]);
    });
  }
  erase_beyond(Table::kLog, pieces(entries.size()),
               before_ ? pieces(before_->log.entries().size()) : 0);
}

}  // namespace eifmap
