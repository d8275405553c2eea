// Why something was refused, waited for or lost: one code, one name, one sentence each. The codes
// go over the wire: never renumber, only add.
#pragma once

#include <cstdint>
#include <span>

namespace eifmap {

enum class Reason : std::int16_t {
  kNone = 0,
  // A map waits to start
  kNoBaseline = 1,
  kTooFewFeatures = 2,
  kTooFewMatches = 3,
  kDirectionUncertain = 4,
  kTooFewPoints = 5,
  kPlanarScene = 6,
  kRelativePoseFailed = 7,
  // Tracking lost or refused
  kScaleFitFailed = 20,
  kTooFewInliers = 21,
  kScaleJump = 22,
  kNotRelocalized = 23,
  kFilterFailed = 24,
  kAmbiguousPlace = 25,
  // Input rejected
  kNoCalibration = 40,
  kBadCalibration = 41,
  kCalibrationMismatch = 42,
  kBadImageSize = 43,
  kBadPixelFormat = 44,
  kCorruptImage = 45,
  kTimeNotIncreasing = 46,
  kBadFeatures = 47,
  kUnknownExtractor = 48,
  kMalformedMessage = 49,
  kCalibrationChanged = 50,
  // Said of poses that are given all the same
  kCalibrationSuspect = 51,
  kSigmaSuspect = 52,
  kMapFull = 53,
  // Absolute measurements refused
  kBadMeasurement = 80,
  kBadMeasurementCovariance = 81,
  kMeasurementWithoutFrame = 82,
  kMeasurementWithoutPose = 83,
  kMeasurementGated = 84,
  kMeasurementTooLong = 85,
  kMeasurementWithoutBaseline = 86,
  kTooManyMeasurements = 87,
  kMeasurementRepeated = 88,
  kMeasurementWithoutLandmark = 89,
  kMeasurementSpare = 90,
  // What was asked for is not there
  kKeyframeUnknown = 110,
  // Loops refused: the map is as it was
  kLoopTooFewInliers = 100,
  kLoopOneSpot = 101,
  kLoopScaleUncertain = 102,
  kLoopImpossible = 103,
  kLoopAmbiguous = 104,
  kLoopNotConfirmed = 105,
  // Merges of two maps refused, besides for what a loop is: both are as they were
  kMergeNotAgreed = 106,
  kMergeUnlike = 107,
  kMergeMeasured = 108,
  // Maps on the disk
  kMapFileUnreadable = 120,
  kMapFileUnknown = 121,
  kMapFileNewer = 122,
  kMapFileDamaged = 123,
  kMapFileOther = 124,
  kMapNotSaved = 125,
  // By command
  kPaused = 130,
  kMapReset = 131,
  // Commands refused
  kUnknownCommand = 140,
  kBadArguments = 141,
  kSecretWanted = 142,
  kNotSigned = 143,
  kBadSignature = 144,
  kOtherRun = 145,
  kTooOld = 146,
  kUnsupported = 147,
  kNoMap = 148,
  kMapIsMetric = 149,
  // The server's own
  kInternalError = 60,
  kTooManyCameras = 64,
};

struct ReasonText {
  Reason reason;
  const char* name;  // upper case, as in reports: NO_BASELINE
  const char* text;  // what happened, in words
  const char* hint;  // what to do about it
};

const ReasonText& describe(Reason reason);
std::span<const ReasonText> all_reasons();

}  // namespace eifmap
