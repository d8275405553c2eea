// scale, metres_per_unit and sigma_log_scale of the wire <-> ScaleState.
#pragma once

#include <cmath>
#include <cstdint>

#include "absolute_measurement.h"

namespace eifmap {

template <class Message>
void write_scale(const ScaleState& state, Message& message) {
  message.scale = static_cast<std::int8_t>(state.status);
  message.metres_per_unit = state.metres_per_unit;
  message.sigma_log_scale = state.sigma;
}

template <class Message>
ScaleState read_scale(const Message& message) {
  return {static_cast<ScaleStatus>(message.scale), message.metres_per_unit,
          message.sigma_log_scale};
}

template <class Message>
bool valid_scale(const Message& message) {
  return (message.scale == Message::SCALE_ARBITRARY || message.scale == Message::SCALE_METRIC) &&
         std::isfinite(message.metres_per_unit) && message.metres_per_unit > 0 &&
         !(message.sigma_log_scale < 0);
}

}  // namespace eifmap
