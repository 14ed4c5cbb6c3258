// Devices of the rig: see synthesis/instruments/simulated_device.h.
#pragma once

#include "synthesis/instruments/device_timing.h"
#include "synthesis/instruments/simulated_device.h"
