// Storage of a host.
#include "storage_file.hpp"

#include <algorithm>
#include <cerrno>

namespace stator::drivers::storage::file {

void StorageFile::step(StoragePorts& ports) {
    if (!ports.block || device_.file == nullptr) return;
    const LogBlock& block = *ports.block;
    const std::size_t length = std::min<std::size_t>(block.length, block.data.size());
    const std::size_t written = std::fwrite(block.data.data(), 1, length, device_.file);
    device_.bytes_written += written;
    if (written == length) return;
    if (device_.errors == 0) device_.reason = errno;
    ++device_.errors;
}

}  // namespace stator::drivers::storage::file
