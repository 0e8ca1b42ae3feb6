# vcpkg install piste --overlay-ports=packaging/vcpkg; piste[tools] has the programs as well. It builds the checkout that
# it stands in; a release names its archive by vcpkg_from_github.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)
set(DYGRAPHS "https://cdn.jsdelivr.net/npm/dygraphs@2.2.1/dist")
vcpkg_download_distfile(SCRIPT
    URLS "${DYGRAPHS}/dygraph.min.js"
    FILENAME "dygraphs-2.2.1.min.js"
    SHA512 8fee912e757faced80be2ad76e5fb25392404c896521ac5b57b15a4a0acc9092d06b6df590d5f3895a5b4def7e9e9f12e9f2d8899b7c3aed095054fce33b8977)
vcpkg_download_distfile(STYLE
    URLS "${DYGRAPHS}/dygraph.min.css"
    FILENAME "dygraphs-2.2.1.min.css"
    SHA512 72d8dfa87d1c7f566fb315b5b9be1131760fc5a01b68637a5cf31716421137657d711b36d42dad2fff5ef16f4eb26fe0bfd84274935cf84ded2c8a883522d212)
set(LEAFLET "https://cdn.jsdelivr.net/npm/leaflet@1.9.4/dist")
vcpkg_download_distfile(PLAN_SCRIPT
    URLS "${LEAFLET}/leaflet.js"
    FILENAME "leaflet-1.9.4.js"
    SHA512 0701dfaebe1cf6499190bc3a89715dcdc75657f3c69158222322162cb953497cd6433c6e4a0e03890502a5abb3fc45a3824e53610a97fe4be7f691b536961faa)
vcpkg_download_distfile(PLAN_STYLE
    URLS "${LEAFLET}/leaflet.css"
    FILENAME "leaflet-1.9.4.css"
    SHA512 65c9fa6e347ff1165b2c4a4b21e3b036dcd11010099d42844b171eb3ad0ca688feda8928a5201c4942143ac79d7439b47319c6433c4847bbc982c2d96dd2c4df)
set(PLOTS "${CURRENT_BUILDTREES_DIR}/plots")
configure_file("${SCRIPT}" "${PLOTS}/dygraph.min.js" COPYONLY)
configure_file("${STYLE}" "${PLOTS}/dygraph.min.css" COPYONLY)
configure_file("${PLAN_SCRIPT}" "${PLOTS}/leaflet.js" COPYONLY)
configure_file("${PLAN_STYLE}" "${PLOTS}/leaflet.css" COPYONLY)

vcpkg_check_features(OUT_FEATURE_OPTIONS FEATURE_OPTIONS FEATURES tools PISTE_APPS)
vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}"
    OPTIONS ${FEATURE_OPTIONS} -DPISTE_TESTS=OFF -DPISTE_UNITY=ON "-DDygraphs_DIR=${PLOTS}" "-DLeaflet_DIR=${PLOTS}")
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/piste)
vcpkg_fixup_pkgconfig()
if("tools" IN_LIST FEATURES)
    vcpkg_copy_tools(AUTO_CLEAN TOOL_NAMES piste-align piste-allan piste-compare piste-descents piste-evaluate piste-export piste-inspect piste-montecarlo piste-replay
        piste-simulate piste-study piste-tune)
endif()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
