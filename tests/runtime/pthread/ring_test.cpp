// What is particular to the ring between threads: its words, and what each race may do to it. Races
// are made by hand here, step by step; the stress makes them by chance.
#include "stator/observe.hpp"
#include "stator/pthread.hpp"
#include "topic_rig.hpp"

namespace stator {
namespace {

using testing::publish;
using testing::Reading;
using testing::TopicOf;

class Ring : public testing::TopicTest {};

TEST_F(Ring, an_entry_holds_sequence_slot_and_readers) {
    const uint64_t entry = entry_of(0xFFFFFFFFU, 254) + 3 * kOneReader;
    EXPECT_EQ(sequence_of(entry), 0xFFFFFFFFU);
    EXPECT_EQ(slot_of(entry), 254);
    EXPECT_EQ(readers_of(entry), 3U);
    // 2^24 readers of one sample: the count begins anew, and touches neither slot nor sequence.
    const uint64_t wrapped = entry_of(7, 5) + (uint64_t{kReaderMask} + 1) * kOneReader;
    EXPECT_EQ(wrapped, entry_of(7, 5));
    static_assert(sizeof(RingEntry) == 8 && std::atomic<uint64_t>::is_always_lock_free);
}

// Parameters are published once and read for ever: the count of readers wraps.
TEST_F(Ring, a_sample_that_is_never_replaced_is_read_beyond_the_count) {
    TopicOf<Reading, 1, 2> topic;
    publish(topic.topic, Reading{0, 1, 0}, 0);
    const uint8_t slot = slot_of(topic.ring[0].word.load());
    topic.ring[0].word.fetch_add((kReaderMask - 5) * kOneReader);  // so many have read already
    topic.users[slot].done.fetch_add(kReaderMask - 5);
    for (uint32_t i = 0; i < 20; ++i) {
        Pin pin;
        pin_entry(topic.topic, 0, pin);
        release(topic.topic, pin);
    }
    EXPECT_TRUE(topic.is_idle());
    publish(topic.topic, Reading{0, 2, 0}, 0);
    publish(topic.topic, Reading{0, 3, 0}, 0);
    EXPECT_TRUE(topic.is_idle());
}

// Between the exchange and the store of `head` a reader may be ahead of `head` by one.
TEST_F(Ring, a_reader_ahead_of_head_goes_neither_back_nor_on) {
    TopicOf<Reading, 2, 5> topic;
    for (uint32_t i = 1; i <= 3; ++i) publish(topic.topic, Reading{0, i, 0}, 0);
    topic.state.head.store(2);  // as if the third commit were not quite done
    uint32_t cursor = 3;
    uint32_t lost = 0;
    Pin pin;
    EXPECT_FALSE(has_unread(topic.topic, cursor));
    EXPECT_FALSE(take_next(topic.topic, cursor, lost, pin));
    ASSERT_TRUE(take_latest(topic.topic, 3, pin));
    EXPECT_EQ(pin.number, 3U);
    release(topic.topic, pin);
    ASSERT_TRUE(take_latest(topic.topic, 2, pin)) << "who has not seen the third";
    EXPECT_EQ(pin.number, 2U);
    release(topic.topic, pin);
    topic.state.head.store(3);
    EXPECT_TRUE(topic.is_idle());
}

// A reader that has seen none says 0, and so does one that has seen the 2^32nd sample.
TEST_F(Ring, none_seen_is_told_from_a_number_that_wrapped) {
    TopicOf<Reading, 2, 5> topic(0xFFFFFFFDU);
    for (uint32_t i = 1; i <= 2; ++i) publish(topic.topic, Reading{0, i, 0}, 0);
    Pin pin;
    ASSERT_TRUE(take_latest(topic.topic, 0, pin));
    EXPECT_EQ(pin.number, 0xFFFFFFFFU);
    release(topic.topic, pin);
    EXPECT_TRUE(has_unread(topic.topic, 0));
    uint32_t cursor = 0;
    uint32_t lost = 0;
    Pin oldest;
    ASSERT_TRUE(take_next(topic.topic, cursor, lost, oldest));
    EXPECT_EQ(oldest.number, 0xFFFFFFFEU);
    release(topic.topic, oldest);

    publish(topic.topic, Reading{0, 3, 0}, 0);
    topic.state.head.store(0xFFFFFFFFU);  // as if the commit were not quite done
    EXPECT_FALSE(has_unread(topic.topic, 0));
    cursor = 0;
    EXPECT_FALSE(take_next(topic.topic, cursor, lost, oldest));
    ASSERT_TRUE(take_latest(topic.topic, 0, pin));
    EXPECT_EQ(pin.number, 0U);
    release(topic.topic, pin);
    topic.state.head.store(0);
    EXPECT_TRUE(topic.is_idle());
}

TEST_F(Ring, the_link_copies_the_sample_whose_number_wrapped) {
    Reading copy{};
    auto* const bytes = reinterpret_cast<uint8_t*>(&copy);
    uint32_t number = 1;
    TopicOf<Reading, 1, 3> empty;
    EXPECT_FALSE(copy_newest(empty.topic, bytes, sizeof copy, number));
    TopicOf<Reading, 1, 3> topic(0xFFFFFFFFU);
    publish(topic.topic, Reading{0, 7, 0}, 0);
    ASSERT_TRUE(copy_newest(topic.topic, bytes, sizeof copy, number));
    EXPECT_EQ(number, 0U);
    EXPECT_EQ(copy.value, 7U);
}

// A reader that read `head` and then was overtaken gets a later sample, and says what it lost.
TEST_F(Ring, an_overtaken_reader_counts_its_losses) {
    TopicOf<Reading, 2, 5> topic;
    for (uint32_t i = 1; i <= 5; ++i) publish(topic.topic, Reading{0, i, 0}, 0);
    topic.state.head.store(3);  // what the reader still sees
    uint32_t cursor = 1;
    uint32_t lost = 0;
    Pin pin;
    ASSERT_TRUE(take_next(topic.topic, cursor, lost, pin));
    EXPECT_EQ(pin.number, 4U);  // number 2 was replaced by it
    EXPECT_EQ(lost, 2U);
    EXPECT_EQ(cursor, 4U);
    release(topic.topic, pin);
    topic.state.head.store(5);
}

TEST_F(Ring, a_slot_on_loan_is_given_to_nobody_else) {
    TopicOf<Reading, 1, 3, 2> topic;
    const Loan first = loan(topic.topic, true);
    const Loan second = loan(topic.topic, true);
    EXPECT_NE(first.slot, second.slot);
    commit(topic.topic, second, nullptr);
    commit(topic.topic, first, nullptr);
    Pin pin;
    ASSERT_TRUE(take_latest(topic.topic, 0, pin));
    EXPECT_EQ(pin.slot, first.slot) << "the last one to commit is the newest";
    EXPECT_EQ(pin.number, 2U);
    release(topic.topic, pin);
    EXPECT_TRUE(topic.is_idle());
}

// Waking is a system call: it is not made while another publisher may wait for the lock.
TEST_F(Ring, thinned_subscribers_are_found_under_the_lock_and_woken_behind_it) {
    TopicOf<Reading, 1, 3, 2> topic;
    ThinnedState states[3];
    const Thinned rows[] = {
        {&states[0], 1000, {0, 1}}, {&states[1], 5000, {0, 2}}, {&states[2], 1000, {0, 4}}};
    topic.topic.thinned = rows;
    topic.topic.thinned_count = 3;
    pending_words[0].bits.store(kAwakeBit);
    EXPECT_EQ(due_thinned(topic.topic, 0), 7U);
    EXPECT_EQ(due_thinned(topic.topic, 2500), 5U);
    EXPECT_EQ(pending_words[0].bits.load(), kAwakeBit) << "found only";
    activate(topic.topic, 3500);
    EXPECT_EQ(pending_words[0].bits.load(), kAwakeBit | 5U);
    EXPECT_EQ(states[0].fires.load(), 3U);
    EXPECT_EQ(states[1].fires.load(), 1U);
    pending_words[0].bits.store(0);
}

// A node's parameters beside the port that publishes them; a logger's input beside what it logs.
TEST_F(Ring, what_a_job_holds_stays_when_it_reads_a_newer_one) {
    TopicOf<Reading, 1, 3> topic;  // the ring, what is held, one on loan, one of the link
    publish(topic.topic, Reading{0, 1, 0}, 0);
    Pin held;
    ASSERT_TRUE(take_latest(topic.topic, 0, held));
    for (uint32_t value = 2; value < 9; ++value) {
        Pin again;
        ASSERT_TRUE(take_latest(topic.topic, 0, again));
        EXPECT_EQ(again.number, value - 1);
        release(topic.topic, again);
        publish(topic.topic, Reading{0, value, 0}, 0);
        EXPECT_EQ(topic.samples[held.slot].value, 1U);
    }
    release(topic.topic, held);
    Pin next;
    ASSERT_TRUE(take_latest(topic.topic, held.number, next)) << "the level now keeps the newest";
    EXPECT_EQ(next.number, 8U);
    EXPECT_TRUE(next.is_kept);
    release(topic.topic, next);
    EXPECT_TRUE(topic.is_idle());
}

// D + one kept by each reading level + one taken from the queue + one loan: enough, and one less is
// not.
TEST_F(Ring, the_slots_are_enough_and_all_needed) {
    TopicOf<Reading, 2, 5>
        topic;  // two levels read the newest, one of them also each, one publishes
    Pin pins[3];
    uint32_t cursor = 0;
    uint32_t lost = 0;
    for (unsigned i = 0; i < 3; ++i) {
        for (uint32_t k = 0; k < 2; ++k) publish(topic.topic, Reading{0, k, 0}, 0);
        current_level = i % 2;
        ASSERT_TRUE(i < 2 ? take_latest(topic.topic, 0, pins[i])
                          : take_next(topic.topic, cursor, lost, pins[i]));
    }
    for (uint32_t i = 0; i < 20; ++i) publish(topic.topic, Reading{0, i, 0}, 0);
    topic.topic.slots = 5;
    const auto publish_some = [&] {  // the sixth slot may still be in the ring
        for (uint32_t i = 0; i < 3; ++i) publish(topic.topic, Reading{0, i, 0}, 0);
    };
    EXPECT_DEATH(publish_some(), "no free slot");
    current_level = kMaxLevels;
}

// A level keeps what it has read as the newest: its slot is not built in, and reading it again
// counts nobody. A newer one lets it go.
TEST_F(Ring, a_level_keeps_the_newest_that_it_has_read) {
    TopicOf<Reading, 1, 2> topic;
    publish(topic.topic, Reading{0, 1, 0}, 0);
    Pin first;
    Pin second;
    ASSERT_TRUE(take_latest(topic.topic, 0, first));
    release(topic.topic, first);
    ASSERT_TRUE(take_latest(topic.topic, 1, second));
    release(topic.topic, second);
    EXPECT_EQ(first.slot, second.slot);
    EXPECT_EQ(readers_of(topic.ring[0].word.load()), 1U);
    publish(topic.topic, Reading{0, 2, 0}, 0);
    publish(topic.topic, Reading{0, 3, 0}, 0);
    EXPECT_EQ(topic.samples[first.slot].value, 1U);
    ASSERT_TRUE(take_latest(topic.topic, 1, second));
    EXPECT_EQ(second.number, 3U);
    EXPECT_EQ(topic.users[first.slot].done.load(), 1U);
    release(topic.topic, second);
    EXPECT_TRUE(topic.is_idle());
}

}  // namespace
}  // namespace stator
