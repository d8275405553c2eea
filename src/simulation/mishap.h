// What may happen to a camera's image: gray levels before the sensor's noise.
#pragma once

#include <opencv2/core.hpp>

namespace eifmap::simulation {

void black_out(cv::Mat& gray);         // CV_32FC1
void cover_right_half(cv::Mat& gray);  // by something near the lens, with a soft border

}  // namespace eifmap::simulation
