// Links between machines: what is sound, new and young comes through, in whatever order machines
// start; nothing else does, and each loss is counted. And which of two instances of a node acts.
#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <vector>

#include "stator/machines/receiver.hpp"
#include "stator/machines/selector.hpp"
#include "stator/machines/sender.hpp"

namespace {

using namespace stator;
using namespace stator::machines;
using Bytes = std::vector<uint8_t>;

struct Sample {
    uint64_t timestamp;
    uint32_t value;
    uint32_t zero = 0;
};
constexpr unsigned kTopics = 2;
constexpr uint32_t kMaxAge_us = 50'000;
constexpr ReceivedTopic kReceived[] = {{sizeof(Sample), kMaxAge_us}, {sizeof(Sample), kMaxAge_us}};
constexpr Identity kSame{1, 2};

struct Got {
    unsigned topic;
    uint64_t timestamp;
    uint32_t value;
    bool operator==(const Got&) const = default;
};

// A machine with its end, both nodes, and what they put on the wire.
class Machine {
  public:
    explicit Machine(uint32_t boot, const Identity& identity = kSame) { start(boot, identity); }
    Machine(const Machine&) = delete;
    Machine& operator=(const Machine&) = delete;

    void start(uint32_t boot, const Identity& identity = kSame) {
        std::destroy_at(&end);
        std::construct_at(&end);
        end.connect(
            this,
            [](void* self, std::span<const uint8_t> frame) {
                static_cast<Machine*>(self)->out.emplace_back(frame.begin(), frame.end());
            },
            boot);
        sender = Sender<kTopics, sizeof(Sample)>(end, identity);
        receiver = Receiver<kTopics, sizeof(Sample)>(end, identity, kReceived);
    }
    void offer(unsigned topic, uint64_t timestamp, uint32_t value) {
        const Sample sample{timestamp, value};
        sender.offer(topic, std::as_bytes(std::span(&sample, 1)));
    }
    // The next frame, if there is one: it goes out at once.
    Bytes frame() {
        out.clear();
        sender.go_on();
        if (out.empty()) return {};
        end.finish();
        return out.front();
    }
    std::vector<Got> take(const Bytes& bytes, uint64_t now_us) {
        end.put(bytes);
        receiver.begin(now_us);
        std::vector<Got> found;
        for (unsigned topic = receiver.next(); topic != kTopics; topic = receiver.next()) {
            Sample sample;
            std::memcpy(&sample, receiver.sample(), sizeof sample);
            found.push_back({topic, receiver.timestamp_us(), sample.value});
        }
        return found;
    }

    End end;
    Sender<kTopics, sizeof(Sample)> sender{end, kSame};
    Receiver<kTopics, sizeof(Sample)> receiver{end, kSame, kReceived};
    std::vector<Bytes> out;
};

// A period of the link on both sides; everything that waits is passed on.
void tick(Machine& a, Machine& b, uint64_t now_us) {
    for (auto [from, to] : {std::pair{&a, &b}, std::pair{&b, &a}}) {
        from->sender.tick();
        for (Bytes frame = from->frame(); !frame.empty(); frame = from->frame()) {
            to->take(frame, now_us);
        }
    }
}

TEST(Link, brings_samples_through_with_their_own_time_once_both_ends_know_each_other) {
    Machine a(7);
    Machine b(9);
    a.offer(0, 0, 1);
    EXPECT_TRUE(b.take(a.frame(), 0).empty());  // a hello; what waits is given up
    EXPECT_FALSE(a.end.is_up());
    tick(a, b, 0);
    tick(a, b, 0);
    ASSERT_TRUE(a.end.is_up() && b.end.is_up());
    EXPECT_EQ(b.end.peer_boot(), 7U);
    a.offer(1, 1000, 11);
    EXPECT_EQ(b.take(a.frame(), 3000), (std::vector<Got>{{1, 1000, 11}}));
    EXPECT_EQ(b.receiver.counts().received, 1U);
    EXPECT_EQ(b.receiver.counts().oldest_us, 2000U);
    EXPECT_EQ(b.receiver.counts().refused, 0U);
}

TEST(Link, sends_the_most_urgent_topic_first_and_of_each_only_the_newest) {
    Machine a(1);
    Machine b(1);
    tick(a, b, 0);
    tick(a, b, 0);
    a.frame();
    a.offer(1, 10, 1);
    a.offer(0, 11, 2);
    a.offer(1, 12, 3);
    EXPECT_EQ(b.take(a.frame(), 20), (std::vector<Got>{{0, 11, 2}}));
    EXPECT_EQ(b.take(a.frame(), 20), (std::vector<Got>{{1, 12, 3}}));
    EXPECT_TRUE(a.frame().empty());
    EXPECT_EQ(a.end.replaced(), 1U);
    EXPECT_EQ(b.receiver.counts().lost, 0U);  // what was never sent is not lost on the link
}

TEST(Link, has_one_frame_on_the_wire) {
    Machine a(1);
    Machine b(1);
    tick(a, b, 0);
    tick(a, b, 0);
    a.offer(0, 10, 1);
    a.offer(1, 10, 1);
    a.out.clear();
    a.sender.go_on();
    a.sender.go_on();
    EXPECT_EQ(a.out.size(), 1U);
    a.end.finish();
    a.sender.go_on();
    EXPECT_EQ(a.out.size(), 2U);
}

TEST(Link, stays_down_between_machines_of_different_graphs) {
    for (const Identity& other : {Identity{1, 3}, Identity{2, 2}}) {
        Machine a(1);
        Machine b(1, other);
        for (int i = 0; i < 5; ++i) tick(a, b, 0);
        EXPECT_FALSE(a.end.is_up() || b.end.is_up());
        EXPECT_TRUE(a.receiver.disagrees() && b.receiver.disagrees());
        // A sender that does not care is refused.
        b.start(1);
        a.end.note_peer(1, 1, true);
        b.end.note_peer(1, 1, false);
        a.offer(0, 10, 1);
        Bytes frame;
        do {
            frame = a.frame();
            EXPECT_TRUE(b.take(frame, 20).empty());
            b.end.note_peer(1, 1, false);
        } while (!frame.empty());
        EXPECT_GE(b.receiver.counts().refused, 1U);
    }
}

TEST(Link, counts_what_is_lost_and_drops_what_comes_twice) {
    Machine a(1);
    Machine b(1);
    tick(a, b, 0);
    tick(a, b, 0);
    std::vector<Bytes> frames;
    for (uint32_t i = 0; i < 6; ++i) {
        a.offer(0, 10 + i, i);
        frames.push_back(a.frame());
    }
    EXPECT_EQ(b.take(frames[0], 20).size(), 1U);
    EXPECT_EQ(b.take(frames[3], 20).size(), 1U);
    EXPECT_EQ(b.receiver.counts().lost, 2U);
    EXPECT_TRUE(b.take(frames[3], 20).empty());
    EXPECT_TRUE(b.take(frames[1], 20).empty());
    EXPECT_EQ(b.receiver.counts().repeated, 2U);
    EXPECT_EQ(b.take(frames[4], 20).size(), 1U);
    EXPECT_EQ(b.receiver.counts().lost, 2U);
}

TEST(Link, refuses_what_a_machine_that_was_frozen_sends_in_a_burst) {
    Machine a(1);
    Machine b(1);
    tick(a, b, 0);
    tick(a, b, 0);
    Bytes burst;
    for (uint32_t i = 0; i < 10; ++i) {
        a.offer(0, i * 10'000, i);
        const Bytes frame = a.frame();
        burst.insert(burst.end(), frame.begin(), frame.end());
    }
    const std::vector<Got> found = b.take(burst, 100'000);
    ASSERT_EQ(found.size(), 5U);
    for (const Got& got : found) EXPECT_LE(100'000 - got.timestamp, kMaxAge_us);
    EXPECT_EQ(b.receiver.counts().too_old, 5U);
}

TEST(Link, refuses_a_time_that_is_far_ahead_and_gives_none_later_than_now) {
    Machine a(1);
    Machine b(1);
    tick(a, b, 0);
    tick(a, b, 0);
    a.offer(0, 1'000'000, 1);
    EXPECT_TRUE(b.take(a.frame(), 10).empty());
    a.offer(0, 12, 2);
    EXPECT_EQ(b.take(a.frame(), 10), (std::vector<Got>{{0, 10, 2}}));
    a.offer(0, 9, 3);  // its clock went back
    EXPECT_TRUE(b.take(a.frame(), 20).empty());
    EXPECT_EQ(b.receiver.counts().too_old, 2U);
}

TEST(Link, is_back_after_each_restart_of_either_side) {
    Machine a(1);
    Machine b(1);
    uint64_t now_us = 0;
    for (uint32_t boot = 2; boot < 102; ++boot) {
        (boot % 2 == 0 ? a : b).start(boot);
        for (int i = 0; i < 4; ++i) tick(a, b, now_us += 100'000);
        ASSERT_TRUE(a.end.is_up() && b.end.is_up()) << boot;
        a.offer(0, now_us, boot);
        Bytes frame = a.frame();
        while (frame.size() > frame_bytes(kHeadBytes + sizeof(Sample))) frame = a.frame();
        ASSERT_EQ(b.take(frame, now_us), (std::vector<Got>{{0, now_us, boot}}));
    }
}

TEST(Link, knows_that_a_silent_peer_is_away) {
    Machine a(1);
    Machine b(1);
    tick(a, b, 0);
    tick(a, b, 0);
    ASSERT_TRUE(b.end.is_up());
    b.take({}, kSilence_us);
    EXPECT_TRUE(b.end.is_up());
    b.take({}, kSilence_us + 1);
    EXPECT_FALSE(b.end.is_up());
}

TEST(Link, takes_no_wrong_sample_through_noise_loss_and_foreign_bytes) {
    std::mt19937 random(17);
    Machine a(1);
    Machine b(1);
    tick(a, b, 0);
    tick(a, b, 0);
    uint32_t sent = 0;
    uint32_t found = 0;
    uint32_t newest = 0;
    for (uint32_t i = 1; i <= 20'000; ++i) {
        const uint64_t now_us = i * 1000;
        if (i % 100 == 0) a.sender.tick();
        a.offer(0, now_us, i);
        Bytes frame = a.frame();
        if (frame.size() <= frame_bytes(kHeadBytes + sizeof(Sample))) ++sent;
        for (uint8_t& byte : frame) {
            if (random() % 1000 == 0) byte = static_cast<uint8_t>(byte ^ (1U << (random() % 8)));
        }
        if (random() % 50 == 0) frame.resize(random() % frame.size());
        if (random() % 50 == 0) {
            Bytes garbage(random() % 60);
            for (uint8_t& byte : garbage) byte = static_cast<uint8_t>(random());
            frame.insert(frame.begin(), garbage.begin(), garbage.end());
        }
        for (const Got& got : b.take(frame, now_us)) {
            ++found;
            ASSERT_EQ(got.topic, 0U);
            ASSERT_GT(got.value, newest);
            ASSERT_EQ(got.timestamp, got.value * 1000);
            newest = got.value;
        }
    }
    const ReceivedCounts& counts = b.receiver.counts();
    EXPECT_EQ(found, counts.received);
    EXPECT_GT(found, sent * 8 / 10);
    EXPECT_LT(found, sent);
    EXPECT_LE(sent - found - counts.lost, 1U);  // the last one may be under way
    EXPECT_GT(counts.damaged, 0U);
    EXPECT_EQ(counts.repeated + counts.too_old, 0U);
}

TEST(Link, loses_bytes_for_which_there_is_no_room_and_goes_on) {
    Machine a(1);
    Machine b(1);
    tick(a, b, 0);
    tick(a, b, 0);
    b.end.put(Bytes(100'000, 0x55));
    a.offer(0, 10, 1);
    a.offer(1, 10, 2);
    b.take({}, 10);
    b.take({0}, 10);
    EXPECT_EQ(b.receiver.counts().damaged, 1U);
    EXPECT_EQ(b.take(a.frame(), 10).size(), 1U);
}

TEST(Selector, gives_the_turn_away_while_disarmed_and_back_at_once_when_the_other_is_old) {
    Selector<1> selector({50'000});
    selector.decide(0, false);
    EXPECT_FALSE(selector.is_remote());
    selector.note_remote(0, 1000);
    selector.decide(2000, false);
    EXPECT_TRUE(selector.is_remote());
    selector.decide(51'000, true);
    EXPECT_TRUE(selector.is_remote());
    selector.decide(51'001, true);
    EXPECT_FALSE(selector.is_remote());
    EXPECT_EQ(selector.fallbacks(), 1U);
    selector.note_remote(0, 60'000);
    selector.decide(60'000, true);
    EXPECT_FALSE(selector.is_remote());  // latched
    EXPECT_TRUE(selector.is_fresh());
    selector.decide(61'000, false);
    EXPECT_TRUE(selector.is_remote());
}

TEST(Selector, does_not_give_the_turn_away_in_the_air) {
    Selector<1> selector({50'000});
    selector.decide(0, true);
    selector.note_remote(0, 1000);
    selector.decide(1000, true);
    EXPECT_FALSE(selector.is_remote());
    EXPECT_EQ(selector.fallbacks(), 0U);
}

TEST(Selector, needs_all_outputs) {
    Selector<2> selector({50'000, 10'000});
    selector.note_remote(0, 1000);
    selector.decide(1000, false);
    EXPECT_FALSE(selector.is_remote());
    selector.note_remote(1, 1000);
    selector.decide(1000, false);
    EXPECT_TRUE(selector.is_remote());
    selector.decide(11'001, true);
    EXPECT_FALSE(selector.is_remote());
}

}  // namespace
