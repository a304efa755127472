// Storage of a host.
#include "storage_file.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>

namespace stator::drivers::storage::file {

void StorageFile::Device::offer(const char* path) {
    struct stat facts {};
    const bool is_file = path != nullptr && ::stat(path, &facts) == 0 && S_ISREG(facts.st_mode);
    if (is_file) reader = std::fopen(path, "rb");
}

void StorageFile::step(StoragePorts& ports) {
    if (ports.block.next()) append(*ports.block);
    if (!ports.request.next() || ports.request->file != FileRequest::File::kLog) return;
    const FilePiece piece = answer(*ports.request);
    ports.piece.publish([&] { return piece; });
}

void StorageFile::append(const LogBlock& block) {
    if (device_.file == nullptr) return;
    const std::size_t length = std::min<std::size_t>(block.length, block.data.size());
    const std::size_t written = std::fwrite(block.data.data(), 1, length, device_.file);
    device_.bytes_written += written;
    if (written == length) return;
    if (device_.errors == 0) device_.reason = errno;
    ++device_.errors;
}

// A log that lost a block has no place where the bytes of a piece surely are.
FilePiece StorageFile::answer(const FileRequest& request) {
    using Result = FilePiece::Result;
    FilePiece piece{.tag = request.tag, .result = Result::kAbsent};
    if (device_.reader == nullptr) return piece;
    piece.logs = 1;
    if (request.log != 0) return piece;
    piece.result = Result::kFailed;
    if (device_.errors != 0 || std::fflush(device_.file) != 0) return piece;
    piece.bytes = static_cast<uint32_t>(std::min<uint64_t>(device_.bytes_written, UINT32_MAX));
    const uint32_t left = piece.bytes - std::min(piece.bytes, request.offset);
    const std::size_t wanted =
        std::min<std::size_t>({request.length, piece.data.size(), std::size_t{left}});
    if (std::fseek(device_.reader, static_cast<long>(request.offset), SEEK_SET) != 0) return piece;
    if (std::fread(piece.data.data(), 1, wanted, device_.reader) != wanted) return piece;
    piece.length = static_cast<uint8_t>(wanted);
    piece.result = Result::kRead;
    return piece;
}

}  // namespace stator::drivers::storage::file
