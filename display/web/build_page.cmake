# cmake -DNODE= -DSOURCE= -DROOT= -DOUT= -P build_page.cmake: builds the page, or says what is missing.

if(NOT NODE)
  message(FATAL_ERROR "The page needs Node.js 18 or newer: apt-get install nodejs npm, then configure again. "
                      "Everything but the page builds without it.")
endif()
if(NOT EXISTS ${ROOT}/node_modules/esbuild)
  message(FATAL_ERROR "The page's npm packages are missing: run `npm ci` in ${ROOT} (./dev build does).")
endif()
execute_process(COMMAND ${NODE} ${SOURCE}/build.mjs ${OUT} RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "Building the page failed; the messages above say where.")
endif()
