"""What all tests share: generated examples may take any time, so that no test depends on how busy the machine is."""

from hypothesis import HealthCheck, settings

settings.register_profile("weft", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("weft")
