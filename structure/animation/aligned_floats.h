// AlignedFloats: zeroed floats for vector code, on cache line borders; large arrays on large pages, which the strided writes of
// a frame need (one row after another is a new small page each time).
#pragma once

#include <cstddef>
#include <memory>

namespace roseau::structure {

class AlignedFloats {
 public:
  AlignedFloats() = default;
  /// Throws std::bad_alloc as new does.
  explicit AlignedFloats(std::size_t count);

  float* data() { return data_.get(); }
  const float* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  float& operator[](std::size_t i) { return data_.get()[i]; }
  float operator[](std::size_t i) const { return data_.get()[i]; }

 private:
  struct Free {
    void operator()(float* data) const;
  };
  std::unique_ptr<float, Free> data_;
  std::size_t size_ = 0;
};

}  // namespace roseau::structure
