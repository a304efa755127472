// Fuzzing: any frames, through the transport and every codec. Nothing may crash, reach outside its
// storage or allocate; a transfer that others' frames come in between of ends well; and afterwards
// the next good transfer is taken, of a node that is known at once, of a new one within the time
// that silent ones keep their storage.
//
// An input is a list of records (fuzz_record.hpp). With STATOR_FUZZ_COUNTS in the environment, the
// program says at its end what it has seen.
#include <atomic>
#include <cstdio>
#include <cstdlib>

#include "every_type.hpp"
#include "fuzz_record.hpp"
#include "stator/dronecan/receiver.hpp"
#include "stator/dronecan/sender.hpp"

// Of the sanitizers' runtime; its header is in another package.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*,
                                                                             std::size_t),
                                                         void (*free_hook)(const volatile void*));

namespace {

using namespace stator::dronecan;
using namespace stator::dronecan::fuzz;

constexpr unsigned kTypes = 17;
// Sends good transfers only; nobody uses its id.
constexpr std::uint8_t kKnownNode = 98;
constexpr std::uint8_t kNewNode = 99;
constexpr int kMostAllowed = 119;
using Good = equipment::esc::Status;

std::atomic<std::uint64_t> allocations{0};
struct {
    std::uint64_t starts = 0;  // first frames of transfers
    std::uint64_t transfers = 0;
    std::uint64_t good = 0;
    std::uint64_t kept = 0;  // good ones that were in progress meanwhile
    std::array<std::uint64_t, kTypes> decoded{};
    std::array<std::uint64_t, kTypes> undecodable{};
} seen;

void require(bool condition) {
    if (!condition) std::abort();
}

// What decodes must come out the same after it was encoded and decoded again.
template <class Message>
bool round_trip(std::span<const std::uint8_t> payload) {
    static Message message;
    static Message again;
    static std::array<std::uint8_t, Message::kType.most_bytes> bytes;
    static std::array<std::uint8_t, Message::kType.most_bytes> bytes_again;
    if (!decode(payload, message)) return false;
    const std::size_t length = encode(message, bytes);
    require(length <= bytes.size());
    require(decode(std::span<const std::uint8_t>(bytes).first(length), again));
    require(encode(again, bytes_again) == length);
    require(bytes == bytes_again);
    return true;
}

// Each type's longest transfer and some more are within its rate.
const auto& wanted() {
    static const auto list = [] {
        std::array<Wanted, kTypes> all{};
        unsigned count = 0;
        for_every_type([&]<class Message>(Message*) {
            constexpr auto kRate = static_cast<std::uint16_t>(Message::kType.most_bytes / 7 + 20);
            all[count++] = {Message::kType, kRate, Message::kType.id == 1};
        });
        require(count == all.size());
        return all;
    }();
    return list;
}

using Bus = Receiver<8, protocol::param::GetSet::Response::kType.most_bytes>;

void decode_newest(const Bus& bus) {
    ++seen.transfers;
    unsigned type = 0;
    for_every_type([&]<class Message>(Message*) {
        if (bus.is<Message>()) {
            ++(round_trip<Message>(bus.payload()) ? seen.decoded : seen.undecodable)[type];
        }
        ++type;
    });
}

void feed(Bus& bus, std::span<const std::uint8_t> input, std::uint64_t& now_us) {
    for (; input.size() >= kRecord; input = input.subspan(kRecord)) {
        const Record record = record_of(input.data());
        const Frame& frame = record.frame;
        now_us += 1000 * std::uint64_t{record.pause_ms};
        if (from_id(frame.id).source == kKnownNode) continue;
        const bool has_tail = frame.length != 0 && frame.length <= kMaxFrameBytes;
        if (has_tail && (frame.data[frame.length - 1U] & Tail::kStart) != 0) ++seen.starts;
        if (bus.accept(frame, now_us)) decode_newest(bus);
    }
}

class GoodNode {
  public:
    explicit GoodNode(std::uint8_t id) : id_(id) {}
    void begin(Bus& bus, std::uint64_t now_us) {
        status_.error_count = ++count_;
        sender_.begin({.source = id_}, static_cast<std::uint8_t>(count_), status_);
        require(sender_.next(frame_) && !bus.accept(frame_, now_us));
    }
    void end(Bus& bus, std::uint64_t now_us) {
        bool complete = false;
        while (sender_.next(frame_)) complete = bus.accept(frame_, now_us);
        Good read;
        require(complete && decode(bus.payload(), read) && read == status_);
        ++seen.good;
    }

  private:
    Sender<Good::kType.most_bytes> sender_;
    Good status_;
    Frame frame_;
    std::uint32_t count_ = 0;
    std::uint8_t id_;
};

void print_counts() {
    std::fprintf(stderr, "{\"starts\": %llu, \"transfers\": %llu, \"good\": %llu, \"kept\": %llu",
                 static_cast<unsigned long long>(seen.starts),
                 static_cast<unsigned long long>(seen.transfers),
                 static_cast<unsigned long long>(seen.good),
                 static_cast<unsigned long long>(seen.kept));
    const auto list = [](const char* name, const std::array<std::uint64_t, kTypes>& counts) {
        std::fprintf(stderr, ", \"%s\": [", name);
        for (unsigned i = 0; i < kTypes; ++i) {
            std::fprintf(stderr, i == 0 ? "%llu" : ", %llu",
                         static_cast<unsigned long long>(counts[i]));
        }
        std::fprintf(stderr, "]");
    };
    list("decoded", seen.decoded);
    list("undecodable", seen.undecodable);
    std::fprintf(stderr, "}\n");
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    __sanitizer_install_malloc_and_free_hooks(
        [](const volatile void*, std::size_t) { ++allocations; }, [](const volatile void*) {});
    if (std::getenv("STATOR_FUZZ_COUNTS") != nullptr) std::atexit(print_counts);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static Bus bus(wanted());
    static GoodNode known(kKnownNode);
    static GoodNode unknown(kNewNode);
    NodeSet nodes;
    nodes.add_range(0, kMostAllowed);
    bus.allow(nodes);
    bus.set_own_id(kOwnId);
    static std::uint64_t now_us = 0;
    const std::uint64_t before = allocations;
    now_us += 10'000'000;

    known.begin(bus, now_us);
    const std::uint64_t begun_us = now_us;
    feed(bus, {data, size}, now_us);
    if (now_us - begun_us <= ReceiverCore::kTransferTimeout_us) {
        known.end(bus, now_us);
        ++seen.kept;
        known.begin(bus, now_us);
        known.end(bus, now_us);
    }
    now_us += ReceiverCore::kTransferTimeout_us + 1'000'001;
    unknown.begin(bus, now_us);
    unknown.end(bus, now_us);
    require(allocations == before);
    now_us += 10'000'000;
    return 0;
}
