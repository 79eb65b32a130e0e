# SPDX-License-Identifier: MIT
# The parsers of the application that targets.cpp runs, without the rest of it.
set(fuzzed_app_sources viewer/preferences_json.cpp serve/message.cpp remote/sibr_message.cpp remote/tcp.cpp)
list(TRANSFORM fuzzed_app_sources PREPEND ${PROJECT_SOURCE_DIR}/src/app/)
