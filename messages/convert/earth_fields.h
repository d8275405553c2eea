// earth and earth_* of the wire <-> EarthState.
#pragma once

#include <cstdint>

#include "absolute_measurement.h"
#include "convert/pose_fields.h"

namespace eifmap {

template <class Message>
void write_earth(const EarthState& state, Message& message) {
  message.earth = static_cast<std::int8_t>(state.status);
  write_pose(state.earth_from_map, message.earth_position, message.earth_quaternion);
  write_covariance(state.covariance, message.earth_covariance);
}

template <class Message>
EarthState read_earth(const Message& message) {
  EarthState state;
  state.status = static_cast<EarthStatus>(message.earth);
  state.earth_from_map = read_pose(message.earth_position, message.earth_quaternion);
  state.covariance = read_covariance(message.earth_covariance);
  return state;
}

template <class Message>
bool valid_earth(const Message& message) {
  if (message.earth == Message::EARTH_UNKNOWN) return true;
  return (message.earth == Message::EARTH_LEVEL || message.earth == Message::EARTH_PLACED) &&
         valid_pose(message.earth_position, message.earth_quaternion);
}

}  // namespace eifmap
