// The random numbers of core/random.h, under the rig's own namespace.
#pragma once

#include "core/random.h"
