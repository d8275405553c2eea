#include "reason.h"

#include <array>

namespace eifmap {
namespace {

constexpr std::array kTexts{
    ReasonText{Reason::kNone, "NONE", "nothing to report", ""},
    ReasonText{Reason::kNoBaseline, "NO_BASELINE",
               "the camera has only rotated or stood still since the anchor image",
               "move the camera sideways by about a tenth of the scene's depth"},
    ReasonText{Reason::kTooFewFeatures, "TOO_FEW_FEATURES", "the image has too few features",
               "point the camera at textured surfaces, check exposure and focus"},
    ReasonText{Reason::kTooFewMatches, "TOO_FEW_MATCHES",
               "too few features match the earlier image",
               "move more slowly or raise the frame rate"},
    ReasonText{Reason::kDirectionUncertain, "DIRECTION_UNCERTAIN",
               "the direction of motion is not yet certain enough",
               "move on, sideways by preference"},
    ReasonText{Reason::kTooFewPoints, "TOO_FEW_POINTS", "too few points have a certain depth",
               "move on, sideways by preference"},
    ReasonText{Reason::kPlanarScene, "PLANAR_SCENE",
               "one plane fills the view and leaves two possible motions",
               "move on, in another direction or turning a little, or bring things at other depths "
               "into view"},
    ReasonText{Reason::kRelativePoseFailed, "RELATIVE_POSE_FAILED",
               "no relative pose explains enough of the matches",
               "check that the scene is mostly at rest and the calibration is this camera's"},
    ReasonText{Reason::kScaleFitFailed, "SCALE_FIT_FAILED",
               "the map does not agree on the length of the last step",
               "move more slowly, keep mapped places in view"},
    ReasonText{Reason::kTooFewInliers, "TOO_FEW_INLIERS",
               "too few map features agree with the pose",
               "move back to where tracking last worked"},
    ReasonText{Reason::kScaleJump, "SCALE_JUMP",
               "the depth of the map jumped, so the pose is not trusted",
               "move back to where tracking last worked"},
    ReasonText{Reason::kNotRelocalized, "NOT_RELOCALIZED",
               "no mapped place is recognized in this image",
               "move back to any place that is mapped"},
    ReasonText{Reason::kFilterFailed, "FILTER_FAILED",
               "the information matrix could not be factored", "report this with the log"},
    ReasonText{Reason::kAmbiguousPlace, "AMBIGUOUS_PLACE",
               "two places explain the image about equally well",
               "bring something into view that is there only once"},
    ReasonText{
        Reason::kNoCalibration, "NO_CALIBRATION", "no calibration for this camera yet",
        "publish eifmap.<camera>.calibration, or give the server --calibration FILE, or a guess "
        "with --hfov DEGREES"},
    ReasonText{Reason::kBadCalibration, "BAD_CALIBRATION", "the calibration is not usable",
               "check the calibration's numbers"},
    ReasonText{Reason::kCalibrationMismatch, "CALIBRATION_MISMATCH",
               "the frame names another calibration than the one known",
               "publish the calibration that belongs to these frames"},
    ReasonText{Reason::kBadImageSize, "BAD_IMAGE_SIZE", "the image's size is not the calibration's",
               "calibrate at the size that is published"},
    ReasonText{Reason::kBadPixelFormat, "BAD_PIXEL_FORMAT", "the pixel format is not supported",
               "publish one of the formats of image_t, MJPEG or GRAY best"},
    ReasonText{Reason::kCorruptImage, "CORRUPT_IMAGE", "the image's bytes could not be decoded",
               "check the camera driver and the link"},
    ReasonText{Reason::kTimeNotIncreasing, "TIME_NOT_INCREASING",
               "the frame is not newer than the last one", "check the publisher's clock"},
    ReasonText{Reason::kBadFeatures, "BAD_FEATURES",
               "a feature is not finite, outside the image or without a sign",
               "check the publisher of the features"},
    ReasonText{Reason::kUnknownExtractor, "UNKNOWN_EXTRACTOR",
               "the features come from an extractor that this server does not know or that "
               "differs from the map's",
               "use the same version of eifmap on both sides"},
    ReasonText{Reason::kMalformedMessage, "MALFORMED_MESSAGE",
               "the message's sizes do not fit its bytes", "check the publisher and the link"},
    ReasonText{Reason::kCalibrationChanged, "CALIBRATION_CHANGED",
               "the calibration changed, a new map was begun", ""},
    ReasonText{Reason::kCalibrationSuspect, "CALIBRATION_SUSPECT",
               "the matches do not fit the calibration: another focal length explains them far "
               "better, so the map is likely to be wrong",
               "check that the calibration is this camera's, at this image size"},
    ReasonText{Reason::kSigmaSuspect, "SIGMA_SUSPECT",
               "what the measurements differ from the map by is not what their sigmas say, so "
               "covariances are wrong by as much",
               "set mapper.sigma_factor as the numbers say, or check what disturbs the images: "
               "rolling shutter, a calibration that is off, compression"},
    ReasonText{Reason::kMapFull, "MAP_FULL",
               "the map has reached its bound: for what comes, what says least is taken out",
               "raise mapper.bound.max_keyframes or max_landmarks, or begin a new map"},
    ReasonText{Reason::kBadMeasurement, "BAD_MEASUREMENT",
               "an absolute measurement's numbers are not finite or out of range",
               "check the publisher of the measurements"},
    ReasonText{Reason::kBadMeasurementCovariance, "BAD_MEASUREMENT_COVARIANCE",
               "an absolute measurement's covariance is not positive definite",
               "give every axis a standard deviation above 0"},
    ReasonText{Reason::kMeasurementWithoutFrame, "MEASUREMENT_WITHOUT_FRAME",
               "no image was taken near the time of an absolute measurement",
               "check that both are stamped by one clock; raise measurement.max_dt_s if images are "
               "rare"},
    ReasonText{Reason::kMeasurementWithoutPose, "MEASUREMENT_WITHOUT_POSE",
               "the image of an absolute measurement's time has no place in the map", ""},
    ReasonText{Reason::kMeasurementGated, "MEASUREMENT_GATED",
               "an absolute measurement contradicts the map",
               "check its standard deviation and the antenna's place on the camera"},
    ReasonText{Reason::kMeasurementTooLong, "MEASUREMENT_TOO_LONG",
               "a travelled distance goes over too many keyframes",
               "report the way travelled more often"},
    ReasonText{Reason::kMeasurementWithoutBaseline, "MEASUREMENT_WITHOUT_BASELINE",
               "the two ends of a distance are at the same place of the map",
               "measure between places further apart"},
    ReasonText{Reason::kTooManyMeasurements, "TOO_MANY_MEASUREMENTS",
               "too many absolute measurements wait for their images",
               "send them at a lower rate, or after the images of their time"},
    ReasonText{Reason::kMeasurementRepeated, "MEASUREMENT_REPEATED",
               "an absolute measurement of this publisher and number has come already",
               "give every start of the publisher a number of its own, and count from it by one"},
    ReasonText{Reason::kMeasurementWithoutLandmark, "MEASUREMENT_WITHOUT_LANDMARK",
               "a distance is of a landmark that the map does not have",
               "name the map and two landmarks of its latest update"},
    ReasonText{Reason::kMeasurementSpare, "MEASUREMENT_SPARE",
               "the keyframe of a gravity measurement has one already",
               "nothing: one a keyframe is enough, and two in a row err together"},
    ReasonText{Reason::kKeyframeUnknown, "KEYFRAME_UNKNOWN",
               "a keyframe that was asked for is not in the map in use, or its covariance is not "
               "known",
               "ask for keyframes of the latest map updates, and name their map"},
    ReasonText{Reason::kMapFileUnreadable, "MAP_FILE_UNREADABLE", "a map's file cannot be read",
               "see that it is there and readable, as the system's words say"},
    ReasonText{Reason::kMapFileUnknown, "MAP_FILE_UNKNOWN",
               "a file that should hold a map does not",
               "name a .eifmap file that eifmap-server has written"},
    ReasonText{Reason::kMapFileNewer, "MAP_FILE_NEWER",
               "a map's file is of a later format than this program knows",
               "use the eifmap-server that wrote it, or a later one"},
    ReasonText{Reason::kMapFileDamaged, "MAP_FILE_DAMAGED",
               "a map's file is damaged, and is left as it is",
               "eifmap-server --check-map FILE says what is whole, --repair keeps that; see to the "
               "disk"},
    ReasonText{Reason::kMapFileOther, "MAP_FILE_OTHER",
               "a map's file is of another calibration than the camera has",
               "nothing, if the camera has changed: a new map begins beside it; else give the "
               "calibration that it was made with"},
    ReasonText{Reason::kMapNotSaved, "MAP_NOT_SAVED",
               "the map cannot be written to the disk: what is mapped from now on is lost with the "
               "process",
               "make room on the disk, or see to its rights; it is tried again with each keyframe"},
    ReasonText{Reason::kLoopTooFewInliers, "LOOP_TOO_FEW_INLIERS",
               "a place seems to be seen again, but too few of its map features agree with a pose",
               "look the same way as the first time"},
    ReasonText{Reason::kLoopOneSpot, "LOOP_ONE_SPOT",
               "what seems to be seen again is all in one part of the image",
               "look the same way as the first time"},
    ReasonText{Reason::kLoopScaleUncertain, "LOOP_SCALE_UNCERTAIN",
               "the depths of a place that seems to be seen again do not tell one scale", ""},
    ReasonText{Reason::kLoopImpossible, "LOOP_IMPOSSIBLE",
               "a place seems to be seen again, further off than the map can have drifted",
               "nothing, where places look alike; else check the calibration"},
    ReasonText{Reason::kLoopAmbiguous, "LOOP_AMBIGUOUS",
               "two old places explain the image about equally well",
               "bring something into view that is there only once"},
    ReasonText{Reason::kLoopNotConfirmed, "LOOP_NOT_CONFIRMED",
               "the filter does not confirm a place that seems to be seen again", ""},
    ReasonText{Reason::kMergeNotAgreed, "MERGE_NOT_AGREED",
               "keyframes in a row do not agree on how two maps belong together", ""},
    ReasonText{Reason::kMergeUnlike, "MERGE_UNLIKE",
               "of what two maps should show of each other too little is seen",
               "nothing, where places look alike; else look the same way as the first time"},
    ReasonText{Reason::kMergeMeasured, "MERGE_MEASURED",
               "two maps show the same place, but the one that was to become a part of the other "
               "has absolute measurements",
               ""},
    ReasonText{Reason::kInternalError, "INTERNAL_ERROR",
               "a fault inside eifmap; the frame was left out", "please report it with the log"},
    ReasonText{Reason::kTooManyCameras, "TOO_MANY_CAMERAS",
               "a camera is not mapped, since the server maps as many as it may",
               "raise max_cameras in the server's configuration, or start another server with "
               "--camera for it"},
};

}  // namespace

const ReasonText& describe(Reason reason) {
  for (const ReasonText& text : kTexts)
    if (text.reason == reason) return text;
  return kTexts[0];
}

std::span<const ReasonText> all_reasons() {
  return kTexts;
}

}  // namespace eifmap
