// What the program and its video plug-in agree on. Both are built from the same sources: the plug-in is a part of the
// program that is loaded late, no extension by others.
#pragma once

#include "drivers/camera/file/video_file.h"
#include "drivers/camera/file/video_writer.h"

namespace roseau::camera {

/// Tells plug-ins left over from another version apart: they would disagree on the layout of these types.
inline constexpr std::uint64_t kVideoPluginVersion =
    1'000'000 * sizeof(Sample) + 1'000 * sizeof(VideoFileOptions) + 10 * sizeof(VideoWriterOptions) + 2;

inline constexpr const char* kVideoPluginVersionSymbol = "roseau_video_plugin_version";
inline constexpr const char* kVideoPluginMakeSymbol = "roseau_video_plugin_make";
inline constexpr const char* kVideoPluginMakeWriterSymbol = "roseau_video_plugin_make_writer";

using VideoPluginVersionFunction = std::uint64_t (*)();
/// The caller owns what is returned. Never null, never throws.
using VideoPluginMakeFunction = VideoFile* (*)(const VideoFileOptions& options);
using VideoPluginMakeWriterFunction = VideoWriter* (*)(const VideoWriterOptions& options);

}  // namespace roseau::camera
