// ImageMotion as Foxglove's image annotations: viewers that know nothing of roseau draw the motion vectors and the targets'
// rectangles over the picture.
#pragma once

#include "core/result.h"
#include "core/sample.h"
#include "schema/messages.h"

namespace roseau::schema {

ImageAnnotationsMessage annotations_from_motion(const ImageMotion& motion, HostTime sample_time);

/// The inverse. Points come back grouped by target, and their motion rounded to float where it is the difference of two
/// positions that a float cannot hold; everything else is exact.
Result<ImageMotion> motion_from_annotations(const ImageAnnotationsMessage& annotations);

}  // namespace roseau::schema
