# Broken variants of the topic code, each with a topology in which the explorer must find a violation.
# A mutant whose text is no longer in one_core_topic.hpp stops the configuration: rewrite the mutant.
set(topic_header "${CMAKE_SOURCE_DIR}/runtime/core/stator/one_core_topic.hpp")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${topic_header}")

# stator_add_mutant(NAME FROM text TO text [FROM .. TO ..] RUN explorer's arguments)
function(stator_add_mutant name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "FROM;TO" "RUN")
    file(READ "${topic_header}" text)
    string(FIND "${text}" "${arg_FROM}" found)
    if(found EQUAL -1)
        message(FATAL_ERROR "mutant ${name}: one_core_topic.hpp does not contain: ${arg_FROM}")
    endif()
    string(REPLACE "${arg_FROM}" "${arg_TO}" text "${text}")
    set(folder "${CMAKE_CURRENT_BINARY_DIR}/mutants/${name}")
    file(CONFIGURE OUTPUT "${folder}/stator/topic.hpp" CONTENT "${text}" @ONLY)
    add_executable(explorer_${name}
        world.cpp $<TARGET_OBJECTS:explorer_main> $<TARGET_OBJECTS:explorer_search>)
    target_include_directories(explorer_${name} PRIVATE "${folder}")
    target_link_libraries(explorer_${name} PRIVATE explorer_executor)
    add_test(NAME Explorer.kills_${name}
             COMMAND explorer_${name} --expect-violation ${arg_RUN})
    set_tests_properties(Explorer.kills_${name} PROPERTIES TIMEOUT 600)
endfunction()

# --- sections ---
stator_add_mutant(no_section_in_loan
    FROM "    const Section section(topic.ceiling);\n    const Loan loaned"
    TO "    const Loan loaned"
    RUN --depth 1 "1w 2w 3r")
stator_add_mutant(no_section_in_commit
    FROM "    const Section section(topic.ceiling);\n    const uint32_t number = append"
    TO "    const uint32_t number = append"
    RUN --depth 1 "1w 2w")

# --- order of the words ---
stator_add_mutant(head_before_ring
    FROM "    topic.ring[head & last].store(mask);\n    state.head.store(head + 1);"
    TO "    state.head.store(head + 1);\n    topic.ring[head & last].store(mask);"
    RUN --depth 2 "1w 2q")
stator_add_mutant(number_after_history
    FROM "    topic.number[loaned.slot].store(head + 1);\n    if (topic.depth == 1) {"
    TO "    if (topic.depth == 1) state.history.store(mask);\n    topic.number[loaned.slot].store(head + 1);\n    if (topic.depth == 1) {"
    RUN --depth 1 "1r 2w 3q")

# --- slots in turn ---
stator_add_mutant(turn_not_taken
    FROM "const uint32_t number = topic.turns->head.load() + 1;"
    TO "const uint32_t number = topic.turns->head.load() + 2;"
    RUN --depth 1 "1w 2r")
stator_add_mutant(head_before_newest
    FROM "        topic.turns->newest.store(sample);\n        topic.turns->head.store(loaned.word);"
    TO "        topic.turns->head.store(loaned.word);\n        topic.turns->newest.store(sample);"
    RUN --depth 1 "1w 2r")
stator_add_mutant(number_of_head
    FROM "return head + ((head ^ slot) & 1U);"
    TO "return head + ((head ^ slot) & 0U);"
    RUN --depth 1 "1w 2q")

# --- pins ---
stator_add_mutant(pins_not_asked
    FROM "free & ~kept;"
    TO "all_slots(topic.slots) & ~kept;"
    RUN --depth 1 "1r 2w")
stator_add_mutant(pin_not_marked
    FROM "    state.free.store(pin.saved_free & ~mask);"
    TO ""
    RUN --depth 1 "1r 2w")
stator_add_mutant(release_omitted
    FROM "    if (marks && topic.turns == nullptr) topic.state->free.store(pin.saved_free);"
    TO "    static_cast<void>(topic), static_cast<void>(pin), static_cast<void>(marks);"
    RUN --depth 1 "1r 2w")
stator_add_mutant(release_sets_the_bit
    FROM "if (marks && topic.turns == nullptr) topic.state->free.store(pin.saved_free);"
    TO "if (marks && topic.turns == nullptr) topic.state->free.store(topic.state->free.load() | slot_mask(static_cast<unsigned>(pin.slot)));"
    RUN --depth 1 "1r 2r 3w")
stator_add_mutant(loan_not_marked
    FROM "    topic.state->free.store(loaned.word & ~slot_mask(loaned.slot));"
    TO ""
    RUN --depth 1 "1w 2w")
stator_add_mutant(loan_not_given_back
    FROM "    topic.state->free.store(loaned.word);"
    TO ""
    RUN --depth 1 "1w 2w")

# --- history ---
stator_add_mutant(newest_not_kept
    FROM "topic.state->load(free, kept);"
    TO "free = topic.state->free.load();"
    RUN --depth 1 "1r 2w 3r")
stator_add_mutant(ring_of_depth
    FROM "2U * topic.depth - 1"
    TO "1U * topic.depth - 1"
    RUN --depth 2 "1w 2q" "1w 2r")
stator_add_mutant(take_not_verified
    FROM "    } while (state.head.load() - next > depth);"
    TO "    } while (false);"
    RUN --depth 2 "1q 2w")
stator_add_mutant(one_sample_skipped
    FROM "if (head - next > depth) next = head - depth;"
    TO "if (head - next >= depth) next = head - depth + 1;"
    RUN --depth 2 "1q 2w")
stator_add_mutant(losses_not_counted
    FROM "    lost += next - cursor;"
    TO ""
    RUN --depth 2 "1q 2w")
stator_add_mutant(oldest_not_dropped
    FROM "state.history.load() & ~oldest;"
    TO "state.history.load() & ~(oldest & 0U);"
    RUN --depth 2 "1q 2w")
stator_add_mutant(next_dropped_for_oldest
    FROM "topic.ring[(head - topic.depth) & last].load();"
    TO "topic.ring[(head - topic.depth + 1) & last].load();"
    RUN --depth 2 "1q 2w")
