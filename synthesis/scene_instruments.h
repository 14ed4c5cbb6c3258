// What a scene can say of instruments on serial lines: the part of scene_description.cpp that concerns them.
#pragma once

#include "synthesis/scene.h"
#include "synthesis/scene_fields.h"

namespace roseau::synthesis {

void describe_timing(SceneFields& fields, DeviceTiming& timing);
void describe_sonic(SceneFields& fields, SonicOptions& sonic);
void describe_tracker(SceneFields& fields, TrackerScene& tracker);
void describe_led_board(SceneFields& fields, LedBoardScene& board);

}  // namespace roseau::synthesis
