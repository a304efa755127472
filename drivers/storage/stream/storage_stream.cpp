// Storage at the other end of a line.
#include "storage_stream.hpp"

#include <algorithm>

namespace stator::drivers::storage::stream {

void StorageStream::step(StoragePorts& ports) {
    if (ports.block.next()) append(*ports.block);
    if (!ports.request.next() || ports.request->file != FileRequest::File::kLog) return;
    ports.piece.publish(
        [&] { return FilePiece{.tag = ports.request->tag, .result = FilePiece::Result::kAbsent}; });
}

void StorageStream::append(const LogBlock& block) {
    if (device_.append == nullptr) return;
    const size_t length = std::min<size_t>(block.length, block.data.size());
    if (!device_.append(block.data.data(), length)) ++device_.errors;
}

}  // namespace stator::drivers::storage::stream
