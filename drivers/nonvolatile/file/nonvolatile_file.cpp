// A file of a host in place of a nonvolatile memory.
#include "nonvolatile_file.hpp"

#include <unistd.h>

namespace stator::drivers::nonvolatile::file {

bool NonvolatileFile::Port::read(uint32_t address, std::span<uint8_t> bytes) const {
    const off_t place = off_t{kHeadBytes} + address;
    return pread(device.file, bytes.data(), bytes.size(), place) ==
           static_cast<ssize_t>(bytes.size());
}

bool NonvolatileFile::Port::write(uint32_t address, std::span<const uint8_t> bytes) const {
    const off_t place = off_t{kHeadBytes} + address;
    return pwrite(device.file, bytes.data(), bytes.size(), place) ==
           static_cast<ssize_t>(bytes.size());
}

void NonvolatileFile::step(NonvolatilePorts& ports) {
    driver_.step(ports, device_.key);
    device_.status = driver_.status();
}

}  // namespace stator::drivers::nonvolatile::file
