// The file of a run that is the memory of its mission device.
#include "mission_memory.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "devices.hpp"

namespace stator::board {

namespace {

int mission_file = -1;

}  // namespace

bool open_mission(const char* path) {
    mission_file = ::open(path, O_RDWR | O_CLOEXEC);
    if (mission_file < 0) {
        std::fprintf(stderr, "error: --mission '%s': %s\n", path, std::strerror(errno));
        return false;
    }
    mission0.read = [](std::uint32_t address, std::span<std::uint8_t> bytes) {
        return pread(mission_file, bytes.data(), bytes.size(), address) ==
               static_cast<ssize_t>(bytes.size());
    };
    mission0.write = [](std::uint32_t address, std::span<const std::uint8_t> bytes) {
        return pwrite(mission_file, bytes.data(), bytes.size(), address) ==
               static_cast<ssize_t>(bytes.size());
    };
    return true;
}

}  // namespace stator::board
