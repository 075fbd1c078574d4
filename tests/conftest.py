import hypothesis

# Property tests draw the same examples in every run, and are not judged by the clock.
hypothesis.settings.register_profile("fixed", derandomize=True, deadline=None)
hypothesis.settings.load_profile("fixed")
