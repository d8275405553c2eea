// Absolute measurements: measurement_t <-> AbsoluteMeasurement.
#pragma once

#include <eifmap/measurement_t.hpp>
#include <string>

#include "absolute_measurement.h"
#include "wire/bytes.h"

namespace eifmap {

struct NamedMeasurement {
  std::string camera;
  AbsoluteMeasurement measurement;  // with an id
};

measurement_t to_message(const NamedMeasurement& measurement);

// Refuses: kMalformedMessage (sizes, name, times, publisher or number, an unknown kind),
// kBadMeasurement and kBadMeasurementCovariance (numbers; see check_measurement).
Decoded<NamedMeasurement> decode_measurement(Bytes bytes);

}  // namespace eifmap
