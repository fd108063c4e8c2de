$(eval $(call kernel_test,start_test,tests/start/start_test.cc tests/start/daemon.cc tests/enforce/sandbox.cc,$O/libenforce.a,-lbpf -lfmt))
$O/tests/start_test: $O/mlccad $O/mlcca-sources
