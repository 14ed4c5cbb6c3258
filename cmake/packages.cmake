# Everything we link that is not ours. All come from Debian 12 (packages.txt).

include(GoogleTest)
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(spdlog REQUIRED)
find_package(fmt REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(GTest REQUIRED)
find_package(Protobuf REQUIRED)  # protoc for schema/; libprotobuf for its tests only
pkg_check_modules(SERIALPORT REQUIRED IMPORTED_TARGET libserialport)
find_package(OpenCV 4.6 REQUIRED COMPONENTS core imgproc video)
find_package(Boost 1.74 REQUIRED)
find_package(nlohmann_json REQUIRED)
pkg_check_modules(TURBOJPEG REQUIRED IMPORTED_TARGET libturbojpeg)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(LZ4 REQUIRED IMPORTED_TARGET liblz4)
pkg_check_modules(DEFLATE REQUIRED IMPORTED_TARGET libdeflate)
pkg_check_modules(SPNG REQUIRED IMPORTED_TARGET spng)  # PNG files of other programs
find_package(PNG REQUIRED)  # for the benchmark only
pkg_check_modules(ZIP REQUIRED IMPORTED_TARGET libzip)
find_package(ZLIB REQUIRED)  # its crc32_combine
find_package(CLI11 2.1 REQUIRED)
pkg_check_modules(SYSTEMD REQUIRED IMPORTED_TARGET libsystemd)
pkg_check_modules(MATIO REQUIRED IMPORTED_TARGET matio)  # MATLAB files of laser-scanned trees
pkg_check_modules(NETCDF REQUIRED IMPORTED_TARGET netcdf)  # exported sessions
find_package(spectra REQUIRED)
pkg_check_modules(HWY REQUIRED IMPORTED_TARGET libhwy)
pkg_check_modules(APRILTAG REQUIRED IMPORTED_TARGET apriltag)

# mrcal brings neither a CMake nor a pkg-config file.
find_path(MRCAL_INCLUDE_DIR mrcal/mrcal.h REQUIRED)
find_library(MRCAL_LIBRARY mrcal REQUIRED)
add_library(mrcal INTERFACE IMPORTED)
target_include_directories(mrcal SYSTEM INTERFACE ${MRCAL_INCLUDE_DIR})
target_link_libraries(mrcal INTERFACE ${MRCAL_LIBRARY})
