#include "published/said_of_map.h"

#include <eifmap/pose_t.hpp>
#include <eifmap/status_t.hpp>

#include "wire/layouts.h"

namespace eifmap {

Decoded<SaidOfMap> said_by_pose(Bytes bytes) {
  const Decoded<pose_t> pose = decode_checked<pose_t>(bytes, scan_pose);
  if (!pose.ok()) return Decoded<SaidOfMap>::refuse(pose.reason, pose.detail);
  Decoded<SaidOfMap> said;
  said.value = {pose.value.camera, pose.value.server_epoch, pose.value.map_seq, {}};
  return said;
}

Decoded<SaidOfMap> said_by_status(Bytes bytes) {
  const Decoded<status_t> status = decode_checked<status_t>(bytes, scan_status);
  if (!status.ok()) return Decoded<SaidOfMap>::refuse(status.reason, status.detail);
  const status_t& s = status.value;
  Decoded<SaidOfMap> said;
  said.value = {s.camera, s.server_epoch, s.map_seq, s.map_digest};
  return said;
}

}  // namespace eifmap
