# SPDX-License-Identifier: BSD-2-Clause
$(eval $(call unit_test,client_test,tests/client/client_test.cc tests/client/exceptions_test.cc tests/client/events_test.cc tests/client/former_receivers_test.cc tests/client/local_source_test.cc tests/client/local_queue_test.cc tests/client/local_restart_test.cc tests/client/local_gone_test.cc tests/client/idle_memory_test.cc tests/control/server.cc,$O/libclient.a $O/librelay.a $O/libcontrol.a,-lfmt))

# libmlcca is installed as a package would do it, and used by a program that does not know this
# tree.
check-client: $O/mlccad $O/mlccactl $O/mlcca-design $(CLIENT_LIBRARY) ## libmlcca, installed, against a real mlccad: root
	$(call say,TEST,a program outside of the tree)
	$(Q)rm -rf $O/client-installed
	$(Q)$(MAKE) --no-print-directory DESTDIR=$(abspath $O)/client-installed PREFIX=/usr install-client install-headers install-python
	$(Q)for test in python_test python_local_test; do \
		LD_LIBRARY_PATH=$O PYTHONPATH=$O/client-installed/usr/lib/python3/dist-packages PYTHONDONTWRITEBYTECODE=1 \
			/usr/bin/python3 -W ignore tests/client/$$test.py 2>$O/$$test.log || { cat $O/$$test.log; exit 1; }; \
		tail -n 3 $O/$$test.log | head -n 1; done
	$(Q)cd tests/client && MYPYPATH=$(abspath $O)/client-installed/usr/lib/python3/dist-packages \
		mypy --no-error-summary --cache-dir=$(abspath $O)/mypy-cache --config-file mypy.ini -p mlcca
	$(Q)for example in lever motor camera logger; do \
		MYPYPATH=$(abspath $O)/client-installed/usr/lib/python3/dist-packages mypy --no-error-summary \
			--cache-dir=$(abspath $O)/mypy-cache --config-file tests/client/mypy-example.ini examples/applications/$$example.py \
			|| exit 1; done
	$(Q)tests/client/run $O $O/client-installed
.PHONY: check-client
$(eval $(call program,tests/speak,tests/client/speak.cc,$O/libclient.a $O/librelay.a $O/libcontrol.a,-lfmt))
