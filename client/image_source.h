// Sources of images made of others, and of the simulated world.
#pragma once

#include <memory>

#include "sequence/image_source.h"
#include "simulation/simulated_world.h"

namespace eifmap {

std::unique_ptr<ImageSource> make_source(SimulatedWorld world);

// The first `count` images of a source.
std::unique_ptr<ImageSource> first_images(std::unique_ptr<ImageSource> source, int count);

// Again and again from the first image on, without an end; the times go on increasing. What is live
// has no end anyway, and stays as it is.
std::unique_ptr<ImageSource> looped(std::unique_ptr<ImageSource> source);

}  // namespace eifmap
