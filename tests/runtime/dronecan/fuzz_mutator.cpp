// Mutates an input of the fuzzer by what it means: whole transfers, of every type, whose checksum
// is right again after their payload was changed; and frames that are lost, doubled, swapped or of
// another node. Some mutations are libFuzzer's own, of plain bytes.
#include <algorithm>
#include <array>
#include <vector>

#include "every_type.hpp"
#include "fuzz_record.hpp"
#include "stator/dronecan/crc.hpp"
#include "stator/dronecan/sender.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

using namespace stator::dronecan;
using namespace stator::dronecan::fuzz;

constexpr std::size_t kMostPayload = protocol::param::GetSet::Response::kType.most_bytes;

constexpr std::array<std::uint8_t, 4> kInfinity{0, 0, 0x80, 0x7F};  // of binary32

struct Random {
    std::uint32_t state;
    std::uint32_t below(std::size_t count) {
        state = state * 1664525 + 1013904223;
        return static_cast<std::uint32_t>((std::uint64_t{state} * count) >> 32);
    }
};

const std::vector<DataType>& types() {
    static const auto list = [] {
        std::vector<DataType> all;
        for_every_type([&]<class Message>(Message*) { all.push_back(Message::kType); });
        return all;
    }();
    return list;
}

// Cuts any payload, also one that no message encodes to.
class Cutter : public FrameCutter {
  public:
    std::vector<Record> cut(const Header& header, std::uint8_t transfer_id, std::uint16_t crc_seed,
                            const std::vector<std::uint8_t>& payload) {
        bytes_.assign(kCrcBytes, 0);
        bytes_.insert(bytes_.end(), payload.begin(), payload.end());
        begin(header, transfer_id, crc_seed, bytes_);
        std::vector<Record> records;
        for (Frame frame; next(frame);) records.push_back({frame, 0});
        return records;
    }

  private:
    std::vector<std::uint8_t> bytes_;
};

using Records = std::vector<Record>;

// The frames after `first` that go on with its transfer, as far as they stand together.
std::size_t end_of_transfer(const Records& records, std::size_t first) {
    for (std::size_t i = first; i < records.size(); ++i) {
        const Frame& frame = records[i].frame;
        if (frame.id != records[first].frame.id || frame.length == 0 || frame.length > 8) return i;
        if ((frame.data[frame.length - 1U] & Tail::kEnd) != 0) return i + 1;
    }
    return records.size();
}

std::vector<std::uint8_t> payload_of(const Records& records, std::size_t first, std::size_t end) {
    std::vector<std::uint8_t> payload;
    for (std::size_t i = first; i < end; ++i) {
        const Frame& frame = records[i].frame;
        const bool has_crc = i == first && end - first > 1;
        for (unsigned k = has_crc ? 2 : 0; k + 1U < frame.length; ++k) {
            payload.push_back(frame.data[k]);
        }
    }
    return payload;
}

// Mostly of the type that it was, now and then of another.
void rewrite_transfer(Records& records, Random& random) {
    const std::size_t first = records.empty() ? 0 : random.below(records.size());
    const std::size_t end = end_of_transfer(records, first);
    std::vector<std::uint8_t> payload = payload_of(records, first, end);
    const DataType& drawn = types()[random.below(types().size())];
    Header header = records.empty() ? Header{} : from_id(records[first].frame.id);
    const auto same = std::find_if(types().begin(), types().end(), [&](const DataType& type) {
        return type.kind == header.kind && type.id == header.type_id;
    });
    const DataType& type = same == types().end() || random.below(4) == 0 ? drawn : *same;
    header.kind = type.kind;
    header.type_id = type.id;
    header.destination = kOwnId;
    if (header.source == 0 && type.id != 1) header.source = 20;
    const std::size_t size = payload.size();
    const std::size_t most = std::min<std::size_t>(kMostPayload, type.most_bytes + 1U);
    payload.resize(kMostPayload);
    payload.resize(random.below(16) == 0 ? 0 : LLVMFuzzerMutate(payload.data(), size, most));
    if (payload.size() >= kInfinity.size() && random.below(16) == 0) {
        std::copy(kInfinity.begin(), kInfinity.end(),
                  payload.begin() + random.below(payload.size() - kInfinity.size() + 1));
    }
    const auto transfer_id = static_cast<std::uint8_t>(random.below(kTransferIds));
    const Records cut = Cutter().cut(header, transfer_id, type.crc_seed, payload);
    records.erase(records.begin() + static_cast<std::ptrdiff_t>(first),
                  records.begin() + static_cast<std::ptrdiff_t>(end));
    records.insert(records.begin() + static_cast<std::ptrdiff_t>(first), cut.begin(), cut.end());
}

void disturb_frame(Records& records, Random& random) {
    const std::size_t i = random.below(records.size());
    const auto at = records.begin() + static_cast<std::ptrdiff_t>(i);
    Frame& frame = records[i].frame;
    std::uint8_t& tail = frame.data[(frame.length + 7U) % 8];
    switch (random.below(8)) {
        case 0:
            records.erase(at);
            break;
        case 1:
            records.insert(at, Record(*at));
            break;
        case 2:
            std::swap(records[i], records[random.below(records.size())]);
            break;
        case 3:
            tail ^= static_cast<std::uint8_t>(1U << (5 + random.below(3)));
            break;
        case 4:
            tail ^= static_cast<std::uint8_t>(1U << random.below(5));
            break;
        case 5:
            frame.id ^= 1U << random.below(7);
            break;  // another sender
        case 6:
            records[i].pause_ms = static_cast<std::uint8_t>(random.below(256));
            break;
        default:
            frame.length = static_cast<std::uint8_t>(random.below(16));
            break;
    }
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned int seed) {
    Random random{seed};
    if (random.below(8) == 0) return LLVMFuzzerMutate(data, size, most);
    Records records;
    for (std::size_t i = 0; i + kRecord <= size; i += kRecord) {
        records.push_back(record_of(data + i));
    }
    if (records.empty() || random.below(4) != 0) {
        rewrite_transfer(records, random);
    } else {
        disturb_frame(records, random);
    }
    const std::size_t count = std::min(records.size(), most / kRecord);
    for (std::size_t i = 0; i < count; ++i) write_record(records[i], data + kRecord * i);
    return kRecord * count;
}
