// Everything that can be set about estimation. The defaults suit a leafy plant or a tree in a camera, 0.3 to 4 Hz, in wind.
#pragma once

#include <optional>
#include <string>

#include "estimation/identify.h"
#include "estimation/wind_calibration.h"

namespace roseau::estimation {

struct EstimationOptions {
  IdentifyOptions identification{.damping_prior = DampingPrior{}};

  // Identification on a sliding window.
  double window_s = 60;
  double window_periods = 30;  // a slow tree gets a window of this many periods if that is longer
  double hop_s = 10;
  double first_window_s = 15;     // the first attempts come this early
  double damping_window_s = 240;  // damping may rest on this much, as long as the frequency has not moved
  double hold_s = 120;            // parameters stay in use this long after the gate last accepted

  // An estimate is settling until both spreads, relative to their values, are below these and, where there is a reference, its
  // calibration rests on this much.
  double settled_frequency_sd = 0.025;
  double settled_damping_sd = 0.3;
  double settled_calibration_s = 60;

  // Force.
  std::optional<double> lag_s;    // unset: 0.25 s, or for slower targets than 1 Hz 0.5 s or a quarter period
  double correlation_time_s = 8;  // of the force
  double max_gap_s = 0.5;         // a longer hole in the displacement starts everything but the parameters anew

  // Wind.
  std::string reference_topic;         // empty: the first wind stream that is not truth
  CalibrationOptions calibration;      // holds the direction of the image plane, if known
  double calibration_interval_s = 10;  // half of it until the first one
  /// Once it rests on this much, it stands: from then on estimates no longer lean on the reference, which may be taken away or
  /// judge them. Unset: it goes on being refined.
  std::optional<double> calibration_final_after_s;
  double uncalibrated_scale = 1;  // without a reference wind_mps = scale * sign(u) sqrt(|u|), u = static displacement

  bool fuse_targets = true;  // /wind/estimate from all accepted and calibrated targets
};

}  // namespace roseau::estimation
