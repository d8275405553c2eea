// The fields of what a map's file holds, each said once for writing and for reading. A change here
// is another format: kFileVersion.
#pragma once

#include "geometry/camera.h"
#include "map/map_contents.h"
#include "map/trajectory_log.h"
#include "storage/byte_stream.h"

namespace eifmap {

// What a map's file says besides the map.
struct MapNames {
  Camera camera;
  std::int64_t seq = 0;          // of the last update that it acknowledges
  std::int64_t last_map_id = 0;  // of the map that was started last
  std::vector<std::int64_t>
      beside;  // maps that were kept then: others are in this one, or given up
};

// What of a map is in its first row.
struct MapHead {
  std::int64_t map_id = 0, epoch = 0;
  MapNames names;
  MapSign map_sign = MapSign::kMinus;
  std::int32_t reference = 0, removed_keyframes = 0, removed_landmarks = 0, num_bends = 0;
  std::uint32_t keyframes = 0, tracks = 0, filter_edges = 0, edges = 0, absolutes = 0, logged = 0;
};

namespace fields {

template <class Io, class T>
void rigid(Io& io, T& pose) {
  io(pose.rotation);
  io(pose.translation);
}

template <class Io, class T>
void camera(Io& io, T& c) {
  io(c.width), io(c.height), io(c.model), io(c.fx), io(c.fy), io(c.cx), io(c.cy);
  for (auto& d : c.distortion) io(d);
}

template <class Io, class T>
void head(Io& io, T& h) {
  io(h.map_id), io(h.epoch), io(h.names.seq), io(h.names.last_map_id);
  visit_plain(io, h.names.beside);
  camera(io, h.names.camera);
  io(h.map_sign), io(h.reference), io(h.removed_keyframes), io(h.removed_landmarks),
      io(h.num_bends);
  io(h.keyframes), io(h.tracks), io(h.filter_edges), io(h.edges), io(h.absolutes), io(h.logged);
}

template <class Io, class T>
void keypoint(Io& io, T& k) {
  io(k.u), io(k.v), io(k.sigma_px), io(k.scale), io(k.angle), io(k.response), io(k.laplacian_sign);
}
inline constexpr std::size_t kKeypointBytes = 25;

// Without the camera's name, which is not the map's.
template <class Io, class T>
void frame(Io& io, T& f) {
  io(f.time_us), io(f.publisher), io(f.seq), io(f.calibration_id), io(f.width), io(f.height);
  io(f.extractor), io(f.extractor_version);
  visit_all(io, f.keypoints, kKeypointBytes, [](auto& to, auto& k) { keypoint(to, k); });
  visit_plain(io, f.descriptors);
}

template <class Io, class T>
void keyframe(Io& io, T& k) {
  io(k.time_us), io(k.carrier);
  rigid(io, k.pose);
  rigid(io, k.carrier_from_this);
}

template <class Io, class Sights>
void sights(Io& io, Sights& all) {
  visit_all(io, all, 8, [](auto& to, auto& s) { to(s.keyframe), to(s.keypoint); });
}

template <class Io, class T>
void relative_pose(Io& io, T& edge) {
  io(edge.i), io(edge.j);
  io(edge.measurement.i_from_j), io(edge.measurement.direction);
  io(edge.measurement.sqrt_information);
}

template <class Io, class T>
void edge(Io& io, T& e) {
  io(e.i), io(e.j);
  visit_all(io, e.matches, 12, [](auto& to, auto& m) { to(m.a), to(m.b), to(m.distance); });
}

template <class Io, class T>
void absolute(Io& io, T& a) {
  io(a.kind), io(a.landmarks[0]), io(a.landmarks[1]), io(a.value), io(a.covariance);
  if constexpr (Io::kReads)
    a.points.resize(io.size(28), RigidPoint(0));
  else
    io.size(a.points.size());
  for (auto& point : a.points) io(point.pose), io(point.in_pose);
}

template <class Io, class T>
void filter_books(Io& io, T& b) {
  io(b.has_gauge), io(b.is_metric), io(b.is_placed), io(b.has_level);
  io(b.gauge.direction), io(b.gauge.length);
  rigid(io, b.earth_from_map);
  io(b.held_up), io(b.absolute_weight), io(b.map_variance), io(b.edge_variance);
  visit_all(io, b.variances_asked_for, 16,
            [](auto& to, auto& v) { to(v.by_median), to(v.by_tenth); });
}

template <class Io, class T>
void noise_books(Io& io, T& b) {
  io(b.factor), io(b.estimate), io(b.keyframes);
}

template <class Io, class T>
void placed(Io& io, T& m) {
  io(m.kind), io(m.tracks[0]), io(m.tracks[1]), io(m.value), io(m.covariance);
  visit_all(io, m.points, 196, [](auto& to, auto& p) {
    to(p.keyframe), to(p.offset), to(p.lever), to(p.offset_covariance), to(p.lever_covariance);
  });
}

template <class Io, class Map>
void count_map(Io& io, Map& counts, auto visit_value) {
  if constexpr (Io::kReads) {
    for (std::size_t n = io.size(2); n > 0; --n) {
      typename Map::key_type key{};
      io(key);
      visit_value(io, counts[key]);
    }
  } else {
    io.size(counts.size());
    for (auto& [key, value] : counts) io(key), visit_value(io, value);
  }
}

template <class Io, class T>
void scale(Io& io, T& s) {
  io(s.state.status), io(s.state.metres_per_unit), io(s.state.sigma), io(s.state.sigma_newest);
  io(s.earth.status);
  rigid(io, s.earth.earth_from_map);
  io(s.earth.covariance);
  visit_all(io, s.waiting, 100, [](auto& to, auto& m) { placed(to, m); });
  visit_all(io, s.contradicting, 100, [](auto& to, auto& m) { placed(to, m); });
  count_map(io, s.counts.kinds,
            [](auto& to, auto& k) { to(k.used), to(k.refused), to(k.dropped); });
  count_map(io, s.counts.refusals, [](auto& to, auto& n) { to(n); });
}

template <class Io, class T>
void words(Io& io, T& w) {
  visit_plain(io, w.minus);
  visit_plain(io, w.plus);
}

template <class Io, class T>
void logged(Io& io, T& entry) {
  io(entry.time_us), io(entry.keyframe);
  rigid(io, entry.keyframe_from_camera);
}

}  // namespace fields
}  // namespace eifmap
