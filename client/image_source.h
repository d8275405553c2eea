// Sources of images made of others, and of the simulated world.
#pragma once

#include <memory>
#include <utility>

#include "sequence/image_source.h"
#include "simulation/simulated_world.h"

namespace eifmap {

// Passes everything on to another source.
class DerivedSource : public ImageSource {
 public:
  explicit DerivedSource(std::unique_ptr<ImageSource> source) : source_(std::move(source)) {}

  std::string name() const override { return source_->name(); }
  std::string kind() const override { return source_->kind(); }
  int size() const override { return source_->size(); }
  bool live() const override { return source_->live(); }
  const Camera& camera() const override { return source_->camera(); }
  std::vector<TumPose> ground_truth() override { return source_->ground_truth(); }
  std::vector<std::string> notes() const override { return source_->notes(); }
  bool has(int i) override { return source_->has(i); }
  std::string problem() const override { return source_->problem(); }
  std::int64_t time_us(int i) override { return source_->time_us(i); }
  GrayImage gray(int i) override { return source_->gray(i); }
  std::optional<FileBytes> jpeg(int i) override { return source_->jpeg(i); }

 protected:
  std::unique_ptr<ImageSource> source_;
};

std::unique_ptr<ImageSource> make_source(SimulatedWorld world);

// The first `count` images of a source.
std::unique_ptr<ImageSource> first_images(std::unique_ptr<ImageSource> source, int count);

// Again and again from the first image on, without an end; the times go on increasing. What is live
// has no end anyway, and stays as it is.
std::unique_ptr<ImageSource> looped(std::unique_ptr<ImageSource> source);

}  // namespace eifmap
