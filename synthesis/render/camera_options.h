// How one camera takes its pictures, beyond what its CameraModel says.
#pragma once

#include <cstdint>

#include "core/frame.h"

namespace roseau::render {

struct CameraOptions {
  PixelFormat format = PixelFormat::bgr8;  // or rgb8, mono8
  /// A picture is the mean of this many, at times spread evenly over the exposure. The LED board needs none of them: its LEDs
  /// are integrated exactly. 1 is enough while motion over the exposure stays below half a pixel.
  int exposure_taps = 1;
  double lens_blur_px = 0.6;  // standard deviation of the lens's point spread; the pixel's area comes on top
  double gain = 1;            // counts per count at gain 1: brightens the picture and its noise
  /// At gain 1: standard deviation of the read noise, and variance per count of signal of the shot noise.
  double read_noise_counts = 1.0;
  double shot_noise_gain = 0.02;
  std::uint64_t noise_seed = 1;
  /// Rolling shutter: how much later each row begins its exposure than the one above; 0: global shutter. Moving things are
  /// drawn in bands of `band_rows`, each at the time of its middle row; the LED board's rows each have their own time.
  double line_delay_s = 0;
  std::uint32_t band_rows = 16;
};

}  // namespace roseau::render
