#include <dlfcn.h>

#include <filesystem>
#include <system_error>

#include "drivers/camera/file/plugin_interface.h"

namespace roseau::camera {

namespace {

// The same place in the build tree and after installation: bin/<program> and lib/roseau/video_file.so.
Result<std::filesystem::path> plugin_path() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return Error{ErrorCode::io, "the program cannot find itself through /proc/self/exe: " + error.message()};
  return program.parent_path().parent_path() / "lib" / "roseau" / "video_file.so";
}

struct Plugin {
  VideoPluginMakeFunction make = nullptr;
  VideoPluginMakeWriterFunction make_writer = nullptr;
};

Result<Plugin> load_plugin() {
  const auto path = plugin_path();
  if (!path) return path.error();
  if (!std::filesystem::exists(*path)) {
    return Error{ErrorCode::not_found,
                 "video files need the plug-in " + path->string() + ", which is missing: install roseau again"};
  }
  // Never unloaded: frames outlive their source, and the code that gives their buffers back is in the plug-in.
  void* library = ::dlopen(path->c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (library == nullptr)
    return Error{ErrorCode::io, "the plug-in for video files cannot be loaded: " + std::string(::dlerror())};
  const auto version = reinterpret_cast<VideoPluginVersionFunction>(::dlsym(library, kVideoPluginVersionSymbol));
  const auto make = reinterpret_cast<VideoPluginMakeFunction>(::dlsym(library, kVideoPluginMakeSymbol));
  const auto make_writer = reinterpret_cast<VideoPluginMakeWriterFunction>(::dlsym(library, kVideoPluginMakeWriterSymbol));
  if (version == nullptr || make == nullptr || make_writer == nullptr || version() != kVideoPluginVersion) {
    return Error{ErrorCode::unsupported,
                 "the plug-in " + path->string() + " belongs to another version of roseau: install roseau again"};
  }
  return Plugin{make, make_writer};
}

const Result<Plugin>& plugin() {
  static const Result<Plugin> loaded = load_plugin();
  return loaded;
}

}  // namespace

Result<std::unique_ptr<VideoFile>> make_video_file(const VideoFileOptions& options) {
  if (!plugin()) return plugin().error();
  return std::unique_ptr<VideoFile>(plugin()->make(options));
}

Result<std::unique_ptr<VideoWriter>> make_video_writer(const VideoWriterOptions& options) {
  if (!plugin()) return plugin().error();
  return std::unique_ptr<VideoWriter>(plugin()->make_writer(options));
}

}  // namespace roseau::camera
