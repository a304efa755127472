# Fails if one of the given static libraries needs a symbol of the C library's maths. Everything
# undefined is looked at, so a new name has to be put on the list of harmless ones on purpose.
set(harmless "^(__assert_fail|abort|memcpy|memset|memmove|memcmp|strlen|__stack_chk_fail|_GLOBAL_OFFSET_TABLE_|__(asan|ubsan|tsan|sanitizer)_.*)$")

foreach(library IN ITEMS ${LIBRARY} ${ALSO})
    execute_process(COMMAND ${NM} -u ${library} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCHALL " [Uw] [^\n]+" symbols "${symbols}")
    foreach(line IN LISTS symbols)
        string(REGEX REPLACE "^ [Uw] " "" symbol "${line}")
        # C++ names are Stator's, Eigen's or the C++ library's, which has no maths of its own.
        if(NOT symbol MATCHES "${harmless}" AND NOT symbol MATCHES "^_Z")
            message(SEND_ERROR "${library} needs ${symbol}")
        endif()
    endforeach()
endforeach()
