// Fuzzing: any frames, through the transport and every codec. Nothing may crash, reach outside its
// storage or allocate, and afterwards the next good transfer is taken.
//
// The input is a list of records of 16 bytes: identifier (4), time since the one before in ms (1),
// length (1), data (8), two unused.
#include <atomic>
#include <cstdlib>
#include <cstring>

#include "every_type.hpp"
#include "stator/dronecan/receiver.hpp"
#include "stator/dronecan/sender.hpp"

// Of the sanitizers' runtime; its header is in another package.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*,
                                                                             std::size_t),
                                                         void (*free_hook)(const volatile void*));

namespace {

using namespace stator::dronecan;

constexpr std::uint8_t kOwnId = 10;
constexpr unsigned kRecord = 16;
std::atomic<std::uint64_t> allocations{0};

void require(bool condition) {
    if (!condition) std::abort();
}

// What decodes must come out the same after it was encoded and decoded again.
template <class Message>
void round_trip(std::span<const std::uint8_t> payload) {
    static Message message;
    static Message again;
    static std::array<std::uint8_t, Message::kType.most_bytes> bytes;
    static std::array<std::uint8_t, Message::kType.most_bytes> bytes_again;
    if (!decode(payload, message)) return;
    const std::size_t length = encode(message, bytes);
    require(length <= bytes.size());
    require(decode(std::span<const std::uint8_t>(bytes).first(length), again));
    require(encode(again, bytes_again) == length);
    require(bytes == bytes_again);
}

const auto& wanted() {
    static const auto list = [] {
        std::array<Wanted, 17> all{};
        unsigned count = 0;
        for_every_type([&]<class Message>(Message*) {
            all[count++] = {Message::kType, 1000, Message::kType.id == 1};
        });
        require(count == all.size());
        return all;
    }();
    return list;
}

using Bus = Receiver<8, protocol::GetNodeInfo::Response::kType.most_bytes>;

void decode_newest(const Bus& bus) {
    for_every_type([&]<class Message>(Message*) {
        if (bus.is<Message>()) round_trip<Message>(bus.payload());
    });
}

void feed(Bus& bus, std::span<const std::uint8_t> input, std::uint64_t& now_us) {
    for (; input.size() >= kRecord; input = input.subspan(kRecord)) {
        Frame frame;
        std::memcpy(&frame.id, input.data(), sizeof frame.id);
        now_us += 1000 * std::uint64_t{input[4]};
        frame.length = input[5] & 0xF;
        std::memcpy(frame.data.data(), input.data() + 6, frame.data.size());
        if (bus.accept(frame, now_us)) decode_newest(bus);
    }
}

// Of a node that was not heard before, once silent ones have given their storage back.
void send_good_transfer(Bus& bus, std::uint64_t now_us) {
    now_us += ReceiverCore::kTransferTimeout_us + 1'000'001;
    equipment::esc::Status status;
    status.error_count = 1234567;
    Sender<equipment::esc::Status::kType.most_bytes> sender;
    sender.begin({.source = 99}, 7, status);
    bool complete = false;
    for (Frame frame; sender.next(frame);) complete = bus.accept(frame, now_us);
    equipment::esc::Status read;
    require(complete && decode(bus.payload(), read) && read == status);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    __sanitizer_install_malloc_and_free_hooks(
        [](const volatile void*, std::size_t) { ++allocations; }, [](const volatile void*) {});
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static Bus bus(wanted());
    NodeSet nodes;
    nodes.add_range(0, kMostNodeId);
    bus.allow(nodes);
    bus.set_own_id(kOwnId);
    static std::uint64_t now_us = 0;
    const std::uint64_t before = allocations;
    now_us += 10'000'000;
    feed(bus, {data, size}, now_us);
    send_good_transfer(bus, now_us);
    require(allocations == before);
    now_us += 10'000'000;
    return 0;
}
